// Battery, motors' power and lights on a CAN bus, in virtual time; and what they do when the bus
// goes away.

#include "musher/modules/device/can_battery.hpp"
#include "musher/modules/device/can_lights.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/modules/device/fake_can.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::device::can_devices_test {

using msg::BmsCmd;
using msg::LedExecute;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

constexpr std::uint32_t kPowerUp = 0x822100;
constexpr std::uint32_t kPowerDown = 0x822200;
constexpr std::uint8_t kMotorsOff = 1U << 3;
constexpr std::uint32_t kFirst = 0x834100;

CanProtocol FileOf(const std::string& name, const CanNames& names) {
  auto file = ReadCanFile(SourceDir() + "/config/device/can/" + name + ".toml", names);
  EXPECT_TRUE(file.config) << name;
  return file.config.value_or(CanProtocol());
}

class OnACanBus : public DevicesOnANetwork {
 protected:
  OnACanBus() {
    config_.touch.source = KeySource::kNone;
    config_.battery.source = BatterySource::kNone;
    config_.led.source = LedSource::kNone;
  }
  void StartOnBus() {
    Dependencies dependencies = Around();
    dependencies.open_can = bus_.Opener();
    devices_ = test::Must(Devices::Make(dependencies, config_));
    Run(Milliseconds(500));  // discovery
  }

  FakeCan bus_;
};

class CanBatteryTest : public OnACanBus {
 protected:
  CanBatteryTest() {
    config_.battery.source = BatterySource::kCan;
    config_.battery.frames = FileOf("battery", BatteryCanNames());
  }
  static CanFrame Charge(int percent) {
    CanFrame frame{{kFirst, true}, kCanBytes, {}, false};
    frame.data[0] = static_cast<std::uint8_t>(percent);
    return frame;
  }
  CanFrame State() const {
    CanFrame frame{{kFirst + 1, true}, kCanBytes, {}, false};
    frame.data[5] = motors_off_ ? kMotorsOff : 0;
    return frame;
  }
  void Report(int percent) {
    bus_.Deliver(Charge(percent));
    bus_.Deliver(State());
  }
  void ReportFor(Duration time, int percent = 80) {
    for (Duration at{}; at < time; at += Milliseconds(100)) {
      Report(percent);
      Run(Milliseconds(100));
    }
  }
  // Its reply once it has one.
  void Request(std::uint8_t motors) {
    replies_.clear();
    BmsCmd::Request request;
    request.electric_machine_command = motors;
    client_->Call(request, Milliseconds(5000), [this](const Result<BmsCmd::Response>& reply) {
      replies_.push_back(reply ? reply.value().code : -1);
    });
    Run(Milliseconds(50));
  }

  bool motors_off_ = true;
  std::vector<std::int32_t> replies_;
  std::unique_ptr<transport::Client<BmsCmd>> client_ =
      test::Must(transport::MakeClient<BmsCmd>(*desk_, "dog1/bms_cmd"));
  std::vector<msg::BmsStatus> received_;
  std::unique_ptr<transport::Subscription> status_ =
      Listen<msg::BmsStatus>("dog1/bms_status", received_);
};

TEST_F(CanBatteryTest, IsPublishedAsBmsStatus) {
  StartOnBus();
  EXPECT_THAT(Failures(), ElementsAre(1409));
  ReportFor(Milliseconds(1000));
  ASSERT_THAT(received_, Not(IsEmpty()));
  EXPECT_EQ(received_.back().batt_soc, 80);
  EXPECT_TRUE(received_.back().power_motor_shutdown) << "as its battery reports";
  motors_off_ = false;
  ReportFor(Milliseconds(1000));
  EXPECT_FALSE(received_.back().power_motor_shutdown);
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(CanBatteryTest, IsReportedWhenOneOfItsFramesIsMissing) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  log_.clear();
  received_.clear();
  for (int i = 0; i < 80; ++i) {
    bus_.Deliver(Charge(80));
    Run(Milliseconds(100));
  }
  EXPECT_THAT(log_, Contains("battery: can0: no frame 0x00834101 for 5000 ms"));
  EXPECT_THAT(log_, SizeIs(1));
  EXPECT_THAT(received_, SizeIs(::testing::Le(1))) << "its last value is not repeated as a new one";
  EXPECT_THAT(Failures(), ElementsAre(1409));
  ReportFor(Milliseconds(1000), 79);
  EXPECT_EQ(received_.back().batt_soc, 79);
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(CanBatteryTest, ThatHasOtherIdsIsReportedWithOneThatCame) {
  StartOnBus();
  for (int i = 0; i < 80; ++i) {
    bus_.Deliver({{0x822100, true}, kCanBytes, {80}, false});
    Run(Milliseconds(100));
  }
  EXPECT_THAT(log_, ElementsAre("battery: can0: no frame 0x00834100 or 0x00834101 for 5000 ms; "
                                "frames of other devices come, such as 0x00822100"));
}

TEST_F(CanBatteryTest, IsReportedAtOnceWhenItsBusIsLostAndUsedWhenItIsBack) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  log_.clear();
  bus_.GoDown();
  EXPECT_THAT(log_, ElementsAre("battery: can0 is down"));
  EXPECT_THAT(Failures(), ElementsAre(1409));
  Run(Milliseconds(5500));
  EXPECT_THAT(log_, SizeIs(1)) << "once";
  bus_.up = true;
  Run(Milliseconds(1100));
  ReportFor(Milliseconds(1000), 79);
  EXPECT_EQ(received_.back().batt_soc, 79);
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(CanBatteryTest, SaysThatItsBusIsOffUntilAFrameComes) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  log_.clear();
  bus_.Fail("can0 is off after too many errors");
  Run(Milliseconds(8000));
  EXPECT_THAT(log_, ElementsAre("battery: can0 is off after too many errors"));
  ReportFor(Milliseconds(1000));
  EXPECT_THAT(Failures(), ElementsAre(1409)) << "it has to last";
  ReportFor(Milliseconds(1000));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(CanBatteryTest, IsReportedOnceWhenItsBusGoesOffAndOnManyTimesASecond) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  log_.clear();
  for (int i = 0; i < 100; ++i) {
    bus_.Fail("can0 is off after too many errors");
    bus_.Fail("can0: no other device takes its frames");
    bus_.Recover();
    Report(80);
    Run(Milliseconds(100));
  }
  EXPECT_THAT(log_, ElementsAre("battery: can0 is off after too many errors"));
  EXPECT_THAT(Failures(), ElementsAre(1409));
}

TEST_F(CanBatteryTest, IsRefusedWithACodeAndASentenceInAFloodToo) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  log_.clear();
  received_.clear();
  for (int i = 0; i < 3000; ++i) {
    bus_.Deliver(Charge(101 + i % 100));
    bus_.Deliver(State());
    if (i % 10 == 9) Run(Milliseconds(1));
  }
  EXPECT_THAT(log_, ElementsAre("battery: refused: frame 0x00834100 has 101 for 'batt_soc', which "
                                "is from 0 up to 100 (1410)"));
  EXPECT_THAT(received_, SizeIs(::testing::Le(1)));
  CanFrame cut = Charge(70);
  cut.size = 2;
  Run(CanLink::kRefusedPause);
  bus_.Deliver(cut);
  EXPECT_THAT(log_,
              Contains(HasSubstr("frame 0x00834100 has 2 bytes, and 'batt_volt' is in byte")));
}

TEST_F(CanBatteryTest, PowersTheMotorsOnceItReportsIt) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  EXPECT_THAT(bus_.TakeIds(), ElementsAre(kPowerUp));
  ReportFor(Milliseconds(500));
  EXPECT_THAT(replies_, IsEmpty()) << "they are still off";
  motors_off_ = false;
  ReportFor(Milliseconds(100));
  EXPECT_THAT(replies_, ElementsAre(0));
  ReportFor(Milliseconds(5000));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
}

// It may still wait in a queue of the bus.
TEST_F(CanBatteryTest, PowersTheMotorsDownAgainThatItHasNotReportedPoweredUp) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  ReportFor(Milliseconds(2500));
  EXPECT_THAT(replies_, ElementsAre(1407));
  EXPECT_THAT(bus_.TakeIds(), ElementsAre(kPowerUp, kPowerDown));
  EXPECT_THAT(log_, Contains(HasSubstr("has not reported the motors powered up within 2000 ms")));
}

TEST_F(CanBatteryTest, PowersTheMotorsDownThatWerePoweredUpWhenItsBusWasLost) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  bus_.GoDown();
  Run(Milliseconds(100));
  EXPECT_THAT(replies_, ElementsAre(1405));
  bus_.TakeIds();
  Run(Milliseconds(5000));
  bus_.up = true;
  bus_.queue_is_full = true;
  Run(Milliseconds(1100));
  ReportFor(Milliseconds(1000));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
  bus_.queue_is_full = false;
  ReportFor(Milliseconds(1000));
  EXPECT_THAT(bus_.TakeIds(), ElementsAre(kPowerDown)) << "once";
}

// The robot may stand by then.
TEST_F(CanBatteryTest, LeavesMotorsPoweredThatHavePowerWhenItsBusIsBackAfterALongTime) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  bus_.GoDown();
  bus_.TakeIds();
  Run(CanBattery::kUndoTime);
  bus_.up = true;
  Run(Milliseconds(1100));
  motors_off_ = false;
  ReportFor(Milliseconds(1000));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
  EXPECT_THAT(log_, Contains(HasSubstr("the motors are powered up, perhaps by the command")));
}

TEST_F(CanBatteryTest, LeavesMotorsPoweredThatHadPowerBeforeTheCommand) {
  motors_off_ = false;
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  bus_.GoDown();
  Run(Milliseconds(100));
  EXPECT_THAT(replies_, ElementsAre(1405));
  bus_.TakeIds();
  bus_.up = true;
  Run(Milliseconds(1100));
  ReportFor(Milliseconds(1000));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
}

TEST_F(CanBatteryTest, RefusesToPowerTheMotorsWithoutItsBus) {
  StartOnBus();
  Request(BmsCmd::kMotorsUp);
  EXPECT_THAT(replies_, ElementsAre(1405)) << "no frame has come yet";
  ReportFor(Milliseconds(1000));
  bus_.Fail("can0 is off after too many errors");
  Request(BmsCmd::kMotorsDown);
  EXPECT_THAT(replies_, ElementsAre(1405))
      << "it never says that they are off which it has not done";
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
}

TEST_F(CanBatteryTest, PowersTheMotorsDownWhilePoweringThemUpWaits) {
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  const auto earlier = replies_;
  EXPECT_THAT(earlier, IsEmpty());
  BmsCmd::Request down;
  down.electric_machine_command = BmsCmd::kMotorsDown;
  std::vector<std::int32_t> down_replies;
  client_->Call(down, Milliseconds(5000), [&](const Result<BmsCmd::Response>& reply) {
    down_replies.push_back(reply ? reply.value().code : -1);
  });
  ReportFor(Milliseconds(300));
  EXPECT_THAT(replies_, ElementsAre(1401));
  EXPECT_THAT(down_replies, ElementsAre(0));
  EXPECT_THAT(bus_.TakeIds(), ElementsAre(kPowerUp, kPowerDown));
}

TEST_F(CanBatteryTest, PowersMotorsUpOnlyWhereThatIsAllowed) {
  may_power_ = Error{1403, "not in LowPower"};
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsUp);
  EXPECT_THAT(replies_, ElementsAre(1403));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
}

TEST_F(CanBatteryTest, WithoutCommandsRefusesToPowerTheMotors) {
  config_.battery.frames.commands.clear();
  StartOnBus();
  ReportFor(Milliseconds(1000));
  Request(BmsCmd::kMotorsDown);
  EXPECT_THAT(replies_, ElementsAre(1408));
}

class CanLightsTest : public OnACanBus {
 protected:
  static constexpr std::uint32_t kHead = 0x4882A00;
  static constexpr std::uint32_t kHeadShown = 0x4892A00;

  CanLightsTest() {
    config_.led.source = LedSource::kCan;
    config_.led.frames[0] = FileOf("head_led", LightCanNames());
  }
  void Acknowledge() {
    bus_.Deliver({{kHeadShown, true}, kCanBytes, {}, false});
    Run(Milliseconds(10));
  }
  std::int32_t Show(std::uint8_t effect, std::uint8_t r = 1, std::uint8_t g = 2,
                    std::uint8_t b = 3) {
    return Call<LedExecute>("dog1/led_execute", {true, "vp", LedExecute::kHead,
                                                 LedExecute::kUserColor, effect, r, g, b})
        .code;
  }
  // The bytes of the last frame.
  std::vector<int> Bytes() const {
    if (bus_.sent.empty()) return {};
    const auto& data = bus_.sent.back().data;
    return {data.begin(), data.begin() + 4};
  }
};

TEST_F(CanLightsTest, GetTheirEffectAndColour) {
  StartOnBus();
  EXPECT_THAT(Bytes(), ElementsAre(LedExecute::kTrailingRace, 6, 33, 226)) << "at the start";
  Acknowledge();
  EXPECT_THAT(Failures(), IsEmpty());
  EXPECT_EQ(Show(LedExecute::kBlink), 0);
  EXPECT_THAT(Bytes(), ElementsAre(LedExecute::kBlink, 1, 2, 3));
  Acknowledge();
  devices_->Enter("TearDown");
  EXPECT_THAT(Bytes(), ElementsAre(LedExecute::kBlinkFast, 255, 50, 50)) << "red, blinking fast";
}

TEST_F(CanLightsTest, AreSentAgainUntilTheyAreAcknowledged) {
  StartOnBus();
  Acknowledge();
  bus_.TakeIds();
  EXPECT_EQ(Show(LedExecute::kBlink), 0);
  Run(Milliseconds(3500));
  EXPECT_THAT(bus_.TakeIds(), SizeIs(4));
  EXPECT_THAT(Failures(), ElementsAre(1109));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("led: head: its board has not acknowledged its light")));
  EXPECT_EQ(Show(LedExecute::kBreath), 1107) << "kept";
  Acknowledge();
  Acknowledge();
  EXPECT_THAT(Failures(), IsEmpty());
  bus_.TakeIds();
  Run(Milliseconds(3000));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
}

TEST_F(CanLightsTest, AreNotShownByTheAcknowledgementOfAnEarlierOne) {
  StartOnBus();
  Acknowledge();
  Show(LedExecute::kBlink);
  Show(LedExecute::kBreath);
  Acknowledge();
  bus_.TakeIds();
  Run(Milliseconds(1100));
  EXPECT_THAT(bus_.TakeIds(), ElementsAre(kHead)) << "the last one is sent again";
}

TEST_F(CanLightsTest, AreShownAgainWhenTheirBusIsBack) {
  StartOnBus();
  Acknowledge();
  bus_.GoDown();
  EXPECT_EQ(Show(LedExecute::kBlink), 1107);
  EXPECT_THAT(Failures(), ElementsAre(1109));
  bus_.TakeIds();
  bus_.up = true;
  Run(Milliseconds(1100));
  EXPECT_THAT(Bytes(), ElementsAre(LedExecute::kBlink, 1, 2, 3));
  Acknowledge();
  EXPECT_THAT(Failures(), IsEmpty());
  bus_.Fail("can0: no other device takes its frames");
  EXPECT_EQ(Show(LedExecute::kBreath), 1107);
  bus_.Recover();
  Run(Milliseconds(1100));
  EXPECT_THAT(Bytes(), ElementsAre(LedExecute::kBreath, 1, 2, 3));
}

TEST_F(CanLightsTest, WithoutAcknowledgementsAreShownOnceSent) {
  config_.led.frames[0]->fields.clear();
  StartOnBus();
  EXPECT_THAT(bus_.TakeIds(), ElementsAre(kHead));
  Run(Milliseconds(3000));
  EXPECT_THAT(bus_.TakeIds(), IsEmpty());
  EXPECT_THAT(Failures(), IsEmpty());
}

}  // namespace musher::device::can_devices_test
