// The lights, the touch pad and the self-check on a simulated network.

#include "musher/modules/device/devices.hpp"

#include <limits>

#include "musher/messages/stamp.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"

namespace musher::device::devices_test {

using msg::LedExecute;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Lights : public DevicesOnANetwork {
 protected:
  std::int32_t RequestEffect(const std::string& client, std::uint8_t effect) {
    return Call<LedExecute>("dog1/led_execute", {true, client, LedExecute::kHead,
                                                 LedExecute::kUserColor, effect, 1, 2, 3})
        .code;
  }
  // The last light that the world shows on a target.
  msg::LedState Last(std::uint8_t target) const {
    msg::LedState last;
    for (const msg::LedState& state : shown_) {
      if (state.target == target) last = state;
    }
    return last;
  }

  std::vector<msg::LedState> shown_;
  std::unique_ptr<transport::Subscription> eye_ =
      Listen<msg::LedState>("dog1/world/led", shown_, kLedQos);
};

TEST_F(Lights, AreShownOnRequestOfAClient) {
  Start();
  EXPECT_EQ(RequestEffect("vp", 4), 0);
  Run(Milliseconds(100));
  EXPECT_EQ(Last(LedExecute::kHead),
            (msg::LedState{LedExecute::kHead, LedExecute::kUserColor, 4, 1, 2, 3, "vp"}));
  EXPECT_EQ(Last(LedExecute::kTail).client, "system");
}

TEST_F(Lights, AreReportedToTheClientAndTheLogWhenRefused) {
  Start();
  EXPECT_EQ(RequestEffect("vp", 77), 1124);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("led_execute of \"vp\": target 1 has no effect 77")));
  EXPECT_EQ(RequestEffect("burglar", 4), 1122);
  EXPECT_EQ(RequestEffect("bms", 4), 0);
  EXPECT_EQ(RequestEffect("tracking", 5), 1125);
  Run(Milliseconds(100));
  EXPECT_EQ(Last(LedExecute::kHead).client, "bms");
}

// The name of a client is untrusted text.
TEST_F(Lights, ForgeNoLinesOfTheLog) {
  Start();
  EXPECT_EQ(RequestEffect("x\nbattery: ok, at 100 %" + std::string(10'000, '!'), 4), 1122);
  ASSERT_THAT(log_, SizeIs(1));
  EXPECT_THAT(log_[0], ::testing::Not(HasSubstr("\n")));
  EXPECT_LT(log_[0].size(), 1000U);
}

TEST_F(Lights, AreAllDeliveredToALateSubscriber) {
  Start();
  for (std::uint8_t effect = 1; effect <= 4; ++effect) EXPECT_EQ(RequestEffect("vp", effect), 0);
  std::vector<msg::LedState> late;
  const auto watcher = Listen<msg::LedState>("dog1/world/led", late, kLedQos);
  Run(Milliseconds(500));
  ASSERT_THAT(late, SizeIs(3));
  EXPECT_EQ(late[0].target, LedExecute::kHead);
  EXPECT_EQ(late[0].effect, 4);
  EXPECT_EQ(late[1].target, LedExecute::kTail);
  EXPECT_EQ(late[2].target, LedExecute::kMini);
}

TEST_F(Lights, FollowTheBattery) {
  Start();
  const auto battery = Publisher<msg::BatteryState>("dog1/world/battery");
  Run(Milliseconds(500));
  msg::BatteryState state;
  state.present = true;
  state.percentage = 0.15F;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(battery->Publish(state));
    Run(Milliseconds(1000));
  }
  EXPECT_EQ(Last(LedExecute::kHead),
            (msg::LedState{LedExecute::kHead, LedExecute::kUserColor, 9, 0xFF, 0x32, 0x32, "bms"}));
  EXPECT_EQ(Last(LedExecute::kMini).effect, 0x30);
}

TEST_F(Lights, FollowTheLifecycle) {
  Start();
  devices_->Enter("LowPower");
  Run(Milliseconds(100));
  EXPECT_EQ(Last(LedExecute::kTail).effect, LedExecute::kRgbOff);
  EXPECT_EQ(Last(LedExecute::kTail).client, "lowpower");
  devices_->Enter("Active");
  Run(Milliseconds(100));
  EXPECT_EQ(Last(LedExecute::kTail).client, "system");
  EXPECT_EQ(Last(LedExecute::kTail).effect, LedExecute::kBreath);
  devices_->Enter("TearDown");
  Run(Milliseconds(100));
  EXPECT_EQ(Last(LedExecute::kHead).effect, LedExecute::kRedBlinkFast);
  EXPECT_EQ(Last(LedExecute::kMini).effect, LedExecute::kCircularRing);
}

TEST_F(Lights, AreCheckedButNotPublishedWithoutLights) {
  config_.led.source = LedSource::kNone;
  Start();
  EXPECT_EQ(RequestEffect("vp", 4), 0);
  EXPECT_EQ(RequestEffect("vp", 77), 1124);
  EXPECT_THAT(shown_, IsEmpty());
}

class Tag : public DevicesOnANetwork {
 protected:
  Tag() { config_.uwb = true; }
  void Measure(float distance, float angle) {
    msg::UwbRaw raw;
    raw.dist = distance;
    raw.angle = angle;
    ASSERT_TRUE(radio_->Publish(raw));
    Run(Milliseconds(100));
  }
  void SetConnected(bool connected) {
    ASSERT_TRUE(connection_->Publish({connected}));
    Run(Milliseconds(100));
  }

  std::vector<msg::UwbRaw> received_;
  std::unique_ptr<transport::Publisher<msg::UwbRaw>> radio_ =
      Publisher<msg::UwbRaw>("dog1/world/uwb", transport::kSensorDataQos);
  std::unique_ptr<transport::Publisher<msg::Bool>> connection_ =
      Publisher<msg::Bool>("dog1/uwb_connected");
  std::unique_ptr<transport::Subscription> tags_ = Listen<msg::UwbRaw>("dog1/uwb_raw", received_);
};

TEST_F(Tag, IsPublishedWhileItIsConnected) {
  Start();
  Measure(2, 0.5F);
  EXPECT_THAT(received_, IsEmpty());
  SetConnected(true);
  Measure(2, 0.5F);
  ASSERT_THAT(received_, SizeIs(1));
  EXPECT_EQ(received_[0].dist, 2);
  SetConnected(false);
  Measure(2, 0.5F);
  EXPECT_THAT(received_, SizeIs(1));
}

TEST_F(Tag, IsNotPublishedWithAnImpossibleReading) {
  Start();
  SetConnected(true);
  Measure(-1, 0);
  Measure(std::numeric_limits<float>::quiet_NaN(), 0);
  EXPECT_THAT(received_, IsEmpty());
  EXPECT_THAT(log_, ElementsAre(HasSubstr("uwb: readings are refused")));
}

TEST_F(Tag, HasASessionAndASelfCheckOfItsOwn) {
  Start();
  const auto session = Call<msg::GetUWBMacSessionID>("dog1/get_uwb_mac_session_id", {});
  EXPECT_EQ(session.code, 0);
  EXPECT_EQ(session.session_id, 1U);
  EXPECT_EQ(session.slave4, 5);
  radio_.reset();
  Run(Milliseconds(500));
  EXPECT_THAT(Failures(), ::testing::Contains(1609));
}

TEST_F(Tag, IsRefusedWithoutARadio) {
  config_.uwb = false;
  Start();
  EXPECT_EQ(Call<msg::GetUWBMacSessionID>("dog1/get_uwb_mac_session_id", {}).code, 1608);
  EXPECT_THAT(Failures(), ::testing::Not(::testing::Contains(1609)));
}

class PowerKeyOfTheRobot : public DevicesOnANetwork {
 protected:
  PowerKeyOfTheRobot() { config_.power_key.source = KeySource::kWorld; }
  void Key(bool pressed) { ASSERT_TRUE(key_->Publish({pressed})); }

  bool refuses_ = false;
  int calls_ = 0;
  std::unique_ptr<transport::Publisher<msg::Bool>> key_ =
      Publisher<msg::Bool>("dog1/world/power_key");
  std::unique_ptr<transport::Server<msg::Trigger>> server_ = test::Must(
      transport::MakeServer<msg::Trigger>(*desk_, "dog1/poweroff", [this](const auto&, auto reply) {
        ++calls_;
        reply({!refuses_, refuses_ ? "the machine is in OTA" : ""});
      }));
};

TEST_F(PowerKeyOfTheRobot, PowersOffOnceWhenItIsHeldForThreeSeconds) {
  Start();
  Key(true);
  Run(Milliseconds(2900));
  EXPECT_EQ(calls_, 0);
  Run(Milliseconds(200));
  EXPECT_EQ(calls_, 1);
  Run(std::chrono::seconds(10));
  EXPECT_EQ(calls_, 1) << "it is still held";
}

TEST_F(PowerKeyOfTheRobot, DoesNothingWhenItIsReleasedBefore) {
  Start();
  for (int i = 0; i < 3; ++i) {
    Key(true);
    Run(Milliseconds(2000));
    Key(false);
    Run(Milliseconds(100));
  }
  EXPECT_EQ(calls_, 0);
}

TEST_F(PowerKeyOfTheRobot, LogsThatThePowerOffIsRefused) {
  refuses_ = true;
  Start();
  Key(true);
  Run(std::chrono::seconds(4));
  EXPECT_THAT(log_, ElementsAre("power key: held for 3000 ms: power-off requested",
                                "power key: poweroff refused: the machine is in OTA"));
}

class Pad : public DevicesOnANetwork {
 protected:
  void Touch(std::int32_t touch_state) {
    ASSERT_TRUE(finger_->Publish({touch_state}));
    Run(Milliseconds(100));
  }
  // The manager's low_power_exit.
  void Serve(bool success) {
    server_ = test::Must(transport::MakeServer<msg::Trigger>(
        *desk_, "dog1/low_power_exit", [this, success](const auto&, auto reply) {
          ++calls_;
          reply({success, success ? "" : "the battery is empty"});
        }));
  }

  int calls_ = 0;
  std::vector<msg::TouchStatus> received_;
  std::unique_ptr<transport::Publisher<msg::Int32>> finger_ =
      Publisher<msg::Int32>("dog1/world/touch");
  std::unique_ptr<transport::Subscription> subscription_ =
      Listen<msg::TouchStatus>("dog1/touch_status", received_);
  std::unique_ptr<transport::Server<msg::Trigger>> server_;
};

TEST_F(Pad, PublishesTouchesWithTheirTime) {
  Start();
  Touch(msg::TouchStatus::kHold);
  ASSERT_THAT(received_, SizeIs(1));
  EXPECT_EQ(received_[0].touch_state, 7);
  EXPECT_EQ(received_[0].timestamp,
            static_cast<std::uint64_t>(FromStamp(received_[0].header.stamp).count()));
  EXPECT_GT(received_[0].timestamp, 0U);
}

TEST_F(Pad, RefusesAnUnknownTouch) {
  Start();
  Touch(99);
  EXPECT_THAT(received_, IsEmpty());
  EXPECT_THAT(log_, ElementsAre("touch: refused: unknown touch 99"));
}

TEST_F(Pad, LeavesLowPowerByADoubleTap) {
  Serve(true);
  Start();
  state_ = "LowPower";
  Touch(msg::TouchStatus::kSingle);
  EXPECT_EQ(calls_, 0);
  Touch(msg::TouchStatus::kDoubleTouch);
  EXPECT_EQ(calls_, 1);
  Touch(msg::TouchStatus::kDoubleTouch);  // too soon
  EXPECT_EQ(calls_, 1);
  Run(Milliseconds(2000));
  Touch(msg::TouchStatus::kDoubleTouch);
  EXPECT_EQ(calls_, 2);
}

// It stood up by a tap of long before.
TEST_F(Pad, DoesNotLeaveLowPowerByADoubleTapThatWaitedWhileItsProcessWasStopped) {
  Serve(true);
  Start();
  state_ = "LowPower";
  network_.Pause(*robot_);
  Touch(msg::TouchStatus::kDoubleTouch);
  Run(std::chrono::seconds(20));
  network_.Resume(*robot_);
  Run(Milliseconds(2500));
  EXPECT_EQ(calls_, 0);
  EXPECT_THAT(log_,
              ElementsAre(HasSubstr("a double tap is ignored: this process could not run for 2")));
  Touch(msg::TouchStatus::kDoubleTouch);
  EXPECT_EQ(calls_, 1);
}

TEST_F(Pad, ChangesNothingByADoubleTapInOtherStates) {
  Serve(true);
  Start();
  Touch(msg::TouchStatus::kDoubleTouch);
  EXPECT_EQ(calls_, 0);
  EXPECT_THAT(received_, SizeIs(1));
}

TEST_F(Pad, LogsWhyTheRobotDoesNotWakeUp) {
  Serve(false);
  Start();
  state_ = "LowPower";
  Touch(msg::TouchStatus::kDoubleTouch);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("leaving low power is requested"),
                                "touch: low_power_exit refused: the battery is empty"));
}

TEST_F(Pad, CallsOnceWithoutAReplyAndLogsTheTimeoutAfter13Seconds) {
  Start();
  state_ = "LowPower";
  Touch(msg::TouchStatus::kDoubleTouch);
  Run(Milliseconds(5000));
  Touch(msg::TouchStatus::kDoubleTouch);
  EXPECT_THAT(log_, SizeIs(1));
  Run(Milliseconds(8000));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("is requested"), HasSubstr("touch: low_power_exit: ")));
}

class DeviceCheck : public DevicesOnANetwork {};

TEST_F(DeviceCheck, FailsForEachDeviceWithoutAPeer) {
  Start();
  EXPECT_THAT(Failures(), ElementsAre(1409, 1509, 1109));
  const auto battery = Publisher<msg::BatteryState>("dog1/world/battery");
  const auto finger = Publisher<msg::Int32>("dog1/world/touch");
  std::vector<msg::LedState> shown;
  const auto eye = Listen<msg::LedState>("dog1/world/led", shown, kLedQos);
  Run(Milliseconds(500));
  EXPECT_THAT(Failures(), ElementsAre(1409));  // present, but no reading yet
  EXPECT_THAT(devices_->Check()[0].result.error().message, HasSubstr("no reading received"));
}

TEST_F(DeviceCheck, LeavesOutSkippedAndMissingDevices) {
  config_.skip = {"bms", "uwb"};
  config_.touch.source = KeySource::kNone;
  Start();
  EXPECT_THAT(devices_->Check(), SizeIs(4));
  EXPECT_THAT(Failures(), ElementsAre(1109));
}

TEST_F(DeviceCheck, PassesWithoutAnyDevice) {
  config_ = {};
  Start();
  EXPECT_THAT(Failures(), IsEmpty());
}

}  // namespace musher::device::devices_test
