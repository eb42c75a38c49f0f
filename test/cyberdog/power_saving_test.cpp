// Calls of CyberDog's power manager when the robot enters and leaves low power.

#include "musher/test/cyberdog/managed_robot.hpp"

namespace musher::testing::power_saving_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class PowerSavingTest : public ManagedRobot {
 protected:
  // A power manager that refuses the first so many calls.
  void ServePower(int refusals = 0) {
    refusals_ = refusals;
    power_ = transport::MakeServer<msg::SetBool>(
                 *app_, "dog/low_power_consumption",
                 [this](const msg::SetBool::Request& request, auto reply) {
                   calls_.push_back(request.data);
                   at_.push_back(robot_.network().now());
                   states_at_call_.push_back(robot_.machine().state);
                   const bool refused = refusals_ > 0 && refusals_-- > 0;
                   reply({!refused, refused ? "the board is busy" : ""});
                 })
                 .value();
  }
  std::vector<bool> Calls() {
    robot_.RunFor(std::chrono::seconds(5));
    return std::exchange(calls_, {});
  }

  std::unique_ptr<transport::Server<msg::SetBool>> power_;
  std::vector<bool> calls_;
  std::vector<Time> at_;
  std::vector<State> states_at_call_;
  int refusals_ = 0;
};

TEST_F(PowerSavingTest, LowPowerIsLeftAtTheStart) {
  ServePower();
  BringUp();
  EXPECT_THAT(Calls(), ElementsAre(false));
}

TEST_F(PowerSavingTest, TheStartTriesThreeTimesASecondApartAndThenContinuesWithARecord) {
  ServePower(100);
  BringUp();
  EXPECT_THAT(Calls(), ElementsAre(false, false, false));
  EXPECT_GE(at_[1] - at_[0], std::chrono::seconds(1));
  EXPECT_GE(at_[2] - at_[1], std::chrono::seconds(1));
  EXPECT_EQ(state(), "Active");
  EXPECT_THAT(Records(), HasSubstr("101 low_power_consumption false failed 3 times: refused: the "
                                   "board is busy"));
}

TEST_F(PowerSavingTest, IsOnInLowPowerAndOffBeforeTheSwitchOutOfIt) {
  ServePower();
  BringUp();
  Calls();
  Take("LowPower");
  EXPECT_THAT(Calls(), ElementsAre(true));
  EXPECT_TRUE(Trigger("low_power_exit").success);
  EXPECT_EQ(state(), "Active");
  EXPECT_THAT(Calls(), ElementsAre(false));
  EXPECT_EQ(states_at_call_.back(), "LowPower");
}

TEST_F(PowerSavingTest, ThatCannotBeLeftKeepsTheRobotInLowPowerAndReportsWhy) {
  ServePower();
  BringUp();
  Take("LowPower");
  Calls();
  refusals_ = 3;
  const auto answer = Trigger("low_power_exit");
  EXPECT_FALSE(answer.success);
  EXPECT_THAT(answer.message, HasSubstr("low_power_consumption false failed 3 times"));
  EXPECT_EQ(state(), "LowPower");
  EXPECT_TRUE(Trigger("low_power_exit").success) << "the board answers again";
  EXPECT_EQ(state(), "Active");
}

TEST_F(PowerSavingTest, IsLeftByASwitchNotRequestedFromTheManager) {
  ServePower();
  BringUp();
  Take("LowPower");
  Calls();
  Take("Active");
  EXPECT_THAT(Calls(), ElementsAre(false));
}

// Each wake word beside a dog with an empty battery switched its board on and off.
TEST_F(PowerSavingTest, IsNotLeftWhereThePolicyRefusesTheWayOut) {
  ServePower();
  BringUp();
  Take("LowPower");
  SetBattery(4);
  Calls();
  EXPECT_FALSE(Trigger("low_power_exit").success) << "the battery is too low";
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(Calls(), IsEmpty());
}

// The board takes seconds, in which a person stops the robot and releases it.
TEST_F(PowerSavingTest, WhatWaitsForTheBoardIsOverWithAnEmergencyStop) {
  ServePower();
  BringUp();
  Take("LowPower");
  Calls();
  refusals_ = 2;
  auto client = transport::MakeClient<msg::Trigger>(*app_, "dog/low_power_exit").value();
  std::optional<Result<msg::Trigger::Response>> answer;
  client->Call({}, std::chrono::minutes(1), [&](auto reply) { answer = std::move(reply); });
  robot_.RunFor(Milliseconds(500));
  robot_.EngageEmergencyStop(StopId(7));
  Settle();
  robot_.ReleaseEmergencyStop();
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_EQ(state(), "LowPower");
  ASSERT_TRUE(answer && answer->ok());
  EXPECT_FALSE(answer->value().success);
  EXPECT_THAT(answer->value().message, HasSubstr("an emergency stop is engaged"));
}

TEST_F(PowerSavingTest, WhatWaitsForTheBoardIsOlderThanASwitchThatComesMeanwhile) {
  ServePower();
  BringUp();
  Take("LowPower");
  Calls();
  refusals_ = 2;
  const auto publish = PublishFunction<msg::UInt8>("machine_state_switch");
  Settle();
  publish({0});  // CyberDog's number of Active
  robot_.RunFor(Milliseconds(500));
  Take("DeActive");
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_EQ(state(), "DeActive");
}

// A board that hangs kept the robot from its TearDown.
TEST_F(PowerSavingTest, DoesNotHoldUpATearDown) {
  ServePower();
  BringUp();
  Take("LowPower");
  Calls();
  refusals_ = 100;
  const auto publish = PublishFunction<msg::UInt8>("machine_state_switch");
  Settle();
  publish({4});  // CyberDog's number of TearDown
  robot_.RunFor(Milliseconds(500));
  EXPECT_EQ(state(), "TearDown");
}

TEST_F(PowerSavingTest, IsNotForTheBatterysLowPower) {
  ServePower();
  BringUp();
  Calls();
  SetBattery(4);
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(Calls(), IsEmpty());
}

TEST_F(PowerSavingTest, IsNotMissedWhereThereIsNoPowerManager) {
  BringUp();
  Take("LowPower");
  EXPECT_TRUE(Trigger("low_power_exit").success);
  EXPECT_EQ(state(), "Active");
  EXPECT_THAT(Records(), ::testing::Not(HasSubstr("low_power_consumption")));
}

}  // namespace musher::testing::power_saving_test
