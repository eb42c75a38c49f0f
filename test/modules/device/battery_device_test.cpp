// The battery on a simulated network, in virtual time.

#include "musher/modules/device/battery_device.hpp"

#include <cmath>
#include <fstream>
#include <limits>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::device::battery_device_test {

using msg::BmsCmd;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class BatteryOnANetwork : public DevicesOnANetwork {
 protected:
  void Say(double percent) {
    msg::BatteryState state;
    state.present = true;
    state.percentage = static_cast<float>(percent / 100);
    ASSERT_TRUE(battery_->Publish(state));
  }
  // A reading each second.
  void SayEachSecond(const std::vector<double>& charges) {
    for (const double percent : charges) {
      Say(percent);
      Run(Milliseconds(1000));
    }
  }
  std::vector<int> Charges() const {
    std::vector<int> charges;
    for (const msg::BmsStatus& status : received_) charges.push_back(status.batt_soc);
    return charges;
  }
  std::int32_t Command(std::uint8_t motors, std::uint8_t charging) {
    const BmsCmd::Response response = Call<BmsCmd>("dog1/bms_cmd", {motors, charging});
    EXPECT_EQ(response.success, response.code == 0);
    return response.code;
  }

  std::vector<msg::BmsStatus> received_;
  std::vector<msg::Bool> power_;
  std::unique_ptr<transport::Publisher<msg::BatteryState>> battery_ =
      Publisher<msg::BatteryState>("dog1/world/battery");
  std::unique_ptr<transport::Subscription> subscription_ =
      Listen<msg::BmsStatus>("dog1/bms_status", received_);
  std::unique_ptr<transport::Subscription> motors_ =
      Listen<msg::Bool>("dog1/world/motor_power", power_, transport::kLatchedQos);
};

TEST_F(BatteryOnANetwork, IsPublishedAsBmsStatus) {
  Start();
  SayEachSecond({80, 80});
  ASSERT_THAT(received_, SizeIs(1));
  EXPECT_EQ(received_[0].header.frame_id, "battery_id");
  EXPECT_GT(FromStamp(received_[0].header.stamp).count(), 0);
  EXPECT_EQ(received_[0].batt_soc, 80);
  EXPECT_THAT(Failures(), ::testing::Not(::testing::Contains(1409)));
}

TEST_F(BatteryOnANetwork, IsPublishedAtMostEvery800MsAndTheLastReadingAlways) {
  Start();
  for (int percent = 80; percent > 60; --percent) {
    Say(percent);
    Run(Milliseconds(100));
  }
  Run(Milliseconds(1000));
  EXPECT_EQ(Charges().back(), 61);
  for (std::size_t i = 1; i < received_.size(); ++i) {
    EXPECT_GE(FromStamp(received_[i].header.stamp) - FromStamp(received_[i - 1].header.stamp),
              Milliseconds(800));
  }
}

TEST_F(BatteryOnANetwork, IsPublishedWhenItFallsInStepsOf30Percent) {
  Start();
  SayEachSecond({100, 100, 70, 40, 10, 0, 0});
  EXPECT_THAT(Charges(), ElementsAre(100, 70, 40, 10, 0));
}

TEST_F(BatteryOnANetwork, IsNotPublishedWhenItJumpsOnce) {
  Start();
  SayEachSecond({80, 80, 3, 79});
  EXPECT_THAT(Charges(), ElementsAre(80, 79));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("ok, at 80 %"),
                                "battery: a jump to 3 % is held until the next reading"));
}

TEST_F(BatteryOnANetwork, IsRefusedWithOneLineWhenItsReadingsAreInvalid) {
  Start();
  SayEachSecond({80, 80});
  log_.clear();
  SayEachSecond({std::nan(""), std::nan(""), std::nan("")});
  EXPECT_THAT(Charges(), ElementsAre(80));
  EXPECT_THAT(log_, ElementsAre("battery: refused: a charge that is not a number"));
  EXPECT_THAT(Failures(), ::testing::Contains(1409));
  SayEachSecond({79});
  EXPECT_THAT(Charges(), ElementsAre(80, 79));
  EXPECT_THAT(Failures(), ::testing::Not(::testing::Contains(1409)));
}

TEST_F(BatteryOnANetwork, IsReportedWhenItFallsSilentAndItsLastValueIsNotRepeated) {
  Start();
  SayEachSecond({80, 80});
  log_.clear();
  Run(Milliseconds(10'000));
  EXPECT_THAT(Charges(), ElementsAre(80));
  EXPECT_THAT(log_, ElementsAre("battery: silent for 5000 ms"));
  EXPECT_EQ(devices_->Check()[0].result.error().message, "silent for 5000 ms");
  SayEachSecond({78});
  EXPECT_THAT(Charges(), ElementsAre(80, 78));
  EXPECT_THAT(log_.back(), HasSubstr("ok, at 78 %"));
}

TEST_F(BatteryOnANetwork, IsReportedAtOnceWhenItsPublisherIsLost) {
  Start();
  SayEachSecond({80, 80});
  log_.clear();
  battery_.reset();
  Run(Milliseconds(500));
  EXPECT_THAT(log_, ElementsAre("battery: no publisher of world/battery"));
  EXPECT_EQ(devices_->Check()[0].result.error().message, "no publisher of world/battery");
}

TEST_F(BatteryOnANetwork, SwitchesTheMotorsPower) {
  Start();
  EXPECT_EQ(Command(BmsCmd::kMotorsDown, 0), 0);
  SayEachSecond({80, 80});
  EXPECT_TRUE(received_.back().power_motor_shutdown);
  EXPECT_EQ(Command(BmsCmd::kMotorsUp, 0), 0);
  SayEachSecond({80});
  EXPECT_FALSE(received_.back().power_motor_shutdown);
  EXPECT_THAT(power_, ElementsAre(msg::Bool{false}, msg::Bool{true}));
}

// A robot whose battery is that of its computer: they were "powered down", and had power.
TEST_F(BatteryOnANetwork, RefusesToSwitchMotorsWithoutASubscriber) {
  motors_.reset();
  Start();
  EXPECT_EQ(Command(BmsCmd::kMotorsDown, 0), 1405);
  EXPECT_THAT(log_, ElementsAre(HasSubstr("world/motor_power has no subscriber")));
  SayEachSecond({80, 80});
  ASSERT_FALSE(received_.empty());
  EXPECT_FALSE(received_.back().power_motor_shutdown);
}

// A program that was restarted after "down" read the "up" of before, and powered the motors.
TEST_F(BatteryOnANetwork, KeepsMotorsDownForASubscriberThatComesAfterTheCommand) {
  Start();
  EXPECT_EQ(Command(BmsCmd::kMotorsUp, 0), 0);
  Run(Milliseconds(1000));
  motors_.reset();
  Run(Milliseconds(1000));
  EXPECT_EQ(Command(BmsCmd::kMotorsDown, 0), 1405);
  power_.clear();
  motors_ = Listen<msg::Bool>("dog1/world/motor_power", power_, transport::kLatchedQos);
  Run(Milliseconds(1000));
  EXPECT_THAT(power_, ElementsAre(msg::Bool{false}));
}

TEST_F(BatteryOnANetwork, PowersNoMotorsForASubscriberThatComesAfterTheCommand) {
  motors_.reset();
  Start();
  EXPECT_EQ(Command(BmsCmd::kMotorsUp, 0), 1405);
  motors_ = Listen<msg::Bool>("dog1/world/motor_power", power_, transport::kLatchedQos);
  Run(Milliseconds(1000));
  EXPECT_THAT(power_, IsEmpty());
}

TEST_F(BatteryOnANetwork, RefusesUnknownCommands) {
  Start();
  EXPECT_EQ(Command(0, 0), 1410);
  EXPECT_EQ(Command(3, 0), 1410);
  EXPECT_EQ(Command(BmsCmd::kMotorsDown, 1), 1410);
  EXPECT_EQ(Command(BmsCmd::kMotorsDown, BmsCmd::kWirelessChargingOn), 1408);
  EXPECT_EQ(Command(0, BmsCmd::kWirelessChargingOff), 1408);
  EXPECT_THAT(power_, IsEmpty());
  EXPECT_THAT(log_, SizeIs(5));
  EXPECT_THAT(log_, Each(HasSubstr("bms_cmd refused: ")));
}

TEST_F(BatteryOnANetwork, PowersMotorsUpOnlyWhereThatIsAllowedAndDownAlways) {
  may_power_ = Error{1403, "not in LowPower"};
  Start();
  EXPECT_EQ(Command(BmsCmd::kMotorsUp, 0), 1403);
  EXPECT_THAT(log_, ElementsAre("bms_cmd refused: not in LowPower"));
  EXPECT_EQ(Command(BmsCmd::kMotorsDown, 0), 0);
  EXPECT_THAT(power_, ElementsAre(msg::Bool{false}));
}

TEST_F(BatteryOnANetwork, ReadsTheHostsBattery) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "BAT0");
  std::ofstream(folder / "BAT0/type") << "Battery\n";
  std::ofstream(folder / "BAT0/capacity") << "64\n";
  config_.battery.source = BatterySource::kHost;
  config_.battery.folder = folder.path();
  Start();
  Run(Milliseconds(3000));
  EXPECT_THAT(Charges(), Each(64));
  EXPECT_GE(received_.size(), 2U);
  std::filesystem::remove_all(folder / "BAT0");
  log_.clear();
  Run(Milliseconds(10'000));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("has no battery"), HasSubstr("silent for 5000 ms"),
                                HasSubstr("has no battery")));
  EXPECT_THAT(Failures(), ::testing::Contains(1409));
}

TEST_F(BatteryOnANetwork, ContinuesWhenTheWorldsClockStartsAgain) {
  const auto hand = Publisher<msg::Clock>(transport::kClockTopic, transport::kClockQos);
  Devices* devices = nullptr;
  clock_ =
      test::Must(transport::Clock::FromTopic(*robot_, [&devices] { devices->OnTimeJumped(); }));
  Start();
  devices = devices_.get();
  const auto tick = [&](std::int32_t second) {
    ASSERT_TRUE(hand->Publish({msg::Stamp{second, 0}}));
    Run(Milliseconds(100));
    Say(80);
    Run(Milliseconds(100));
  };
  for (const std::int32_t second : {1000, 1001, 1002}) tick(second);
  EXPECT_THAT(received_, SizeIs(2));
  for (const std::int32_t second : {1, 2, 3}) tick(second);
  EXPECT_THAT(received_, SizeIs(5));
  EXPECT_EQ(received_.back().header.stamp, (msg::Stamp{3, 0}));
}

}  // namespace musher::device::battery_device_test
