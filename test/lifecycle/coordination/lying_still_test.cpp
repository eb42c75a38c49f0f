// A robot that lies still for half a minute goes to LowPower, if the rule is switched on.

#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::lying_still_test {

constexpr std::int32_t kLying = 0;
constexpr std::int32_t kLyingDown = 101;
constexpr std::int32_t kWalking = 303;

class LyingStill : public Rules {
 protected:
  void SetUp() override {
    Robot();
    RequestPolicy(PolicyRequest::kLowPowerSwitch, true);
  }
  void Pass(int seconds) { robot().RunFor(std::chrono::seconds(seconds)); }
};

TEST_F(LyingStill, ForThirtySecondsLeadsToLowPower) {
  Motion(kLying);
  Pass(29);
  EXPECT_EQ(state(), "Active");
  Pass(2);
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(Why(EventName::kSwitchDone), Are(texts::SwitchEnded(3, SwitchOutcome::kDone, ""),
                                               texts::LyingStill(std::chrono::seconds(30))));
}

TEST_F(LyingStill, CountsFromProtectedToo) {
  robot().Set("Protected");
  Motion(kLyingDown);
  Pass(31);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, DoesNotWaitBecauseASwitchThatAPersonRequestedWasUndone) {
  robot().Set("Protected");
  Motion(kLying);
  robot().RunFor(Milliseconds(29'900));
  robot().On("a", "Active").code = 3009;
  ASSERT_EQ(robot().Set("Active").outcome, SwitchOutcome::kUndone);
  robot().RunFor(Milliseconds(500));
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, AnyOtherMotionRestartsTheCount) {
  Motion(kLying);
  Pass(29);
  Motion(kWalking);
  Motion(kLyingDown);
  Pass(29);
  EXPECT_EQ(state(), "Active");
  Pass(2);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, LyingDownAndLyingAreOneStillness) {
  Motion(kLyingDown);
  Pass(20);
  Motion(kLying);
  Pass(11);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, SilenceIsNotStillness) {
  Motion(kLying);
  Pass(20);
  robot().Feed(event::InputSilent{PolicyInput::kMotion});
  Pass(60);
  EXPECT_EQ(state(), "Active");
}

TEST_F(LyingStill, DoesNotCountInOtaNorInDeActive) {
  Motion(kLying);
  for (const BuiltInState other : {kOta, kDeActive}) {
    robot().Set(other);
    Pass(60);
    EXPECT_EQ(state(), other);
  }
}

TEST_F(LyingStill, RestartsTheCountAfterLowPower) {
  Motion(kLying);
  Pass(31);
  ASSERT_EQ(state(), "LowPower");
  Pass(60);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp), "ok");
  Pass(25);
  EXPECT_EQ(state(), "Active");
  Pass(5);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, TurningTheSwitchOffEndsTheRuleAndWakesUp) {
  Motion(kLying);
  Pass(31);
  ASSERT_EQ(state(), "LowPower");
  EXPECT_EQ(RequestAndWait(PolicyRequest::kLowPowerSwitch, false), "ok");
  EXPECT_EQ(state(), "Active");
  Pass(60);
  EXPECT_EQ(state(), "Active");
}

TEST_F(LyingStill, TurningTheSwitchOffDoesNotRaiseAMachineThatTheBatteryTookDown) {
  Battery(3);
  ASSERT_EQ(state(), "LowPower");
  EXPECT_EQ(RequestAndWait(PolicyRequest::kLowPowerSwitch, false), "ok");
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, TurningTheSwitchOffDoesNotRaiseAPersonsLowPowerOnceCharged) {
  robot().Set("LowPower");
  Battery(3);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kLowPowerSwitch, false), "ok");
  Battery(90);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, AMachineThatLayStillInProtectedIsNotRaisedByTheBattery) {
  Battery(10);
  Motion(kLying);
  Pass(31);
  ASSERT_EQ(state(), "LowPower");
  Battery(90);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(LyingStill, TheStoredSwitchSurvivesTheControllerTheOtherDoesNot) {
  robot().RestartController();
  Pass(1);
  EXPECT_FALSE(policy().low_power) << "off by default";
  EXPECT_EQ(RequestAndWait(PolicyRequest::kLowPowerStore, true), "ok");
  robot().RestartController();
  Pass(1);
  EXPECT_TRUE(policy().low_power);
}

TEST_F(LyingStill, ARefusedSwitchDownIsNotRetriedInALoop) {
  MachineConfig config = WithPolicy();
  config.policy->low_power->enabled = true;
  std::erase_if(config.flow, [](const FlowEdge& edge) { return edge.to == "LowPower"; });
  Robot("Active", config);
  Motion(kLying);
  int steps = 0;
  robot().after_step = [&] { ++steps; };
  Pass(600);
  EXPECT_LT(steps, 40);
}

TEST_F(LyingStill, WithoutTheRuleItsSwitchIsRefused) {
  MachineConfig config = WithPolicy();
  config.policy->low_power.reset();
  Robot("Active", config);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kLowPowerSwitch, true),
            "108: the config has no [policy.low_power]");
}

// With /clock.

class OnClockTopic : public Rules {
 protected:
  void SetUp() override {
    MachineConfig config = WithPolicy();
    config.clock = ClockSource::kTopic;
    config.policy->low_power->enabled = true;
    Robot("Active", config);
  }
  void Clock(int seconds) {
    robot().Feed(event::ClockReceived{Time(std::chrono::seconds(seconds))});
    robot().RunFor(Milliseconds(500));
  }
};

TEST_F(OnClockTopic, SteadyTimeDoesNotCount) {
  Clock(100);
  Motion(kLying);
  robot().RunFor(std::chrono::hours(1));
  EXPECT_EQ(state(), "Active");
  EXPECT_EQ(NextPolicyDeadline(robot().config(), robot().machine()),
            Time(std::chrono::seconds(130)));
  EXPECT_EQ(NextDeadline(robot().config(), robot().machine()), std::nullopt);
  Clock(129);
  EXPECT_EQ(state(), "Active");
  Clock(130);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(OnClockTopic, ARestartedClockKeepsTheRemainingTime) {
  Clock(100);
  KeepAndWait("Active", 30);
  Clock(120);
  Clock(5);
  Clock(14);
  EXPECT_TRUE(policy().keep);
  Clock(15);
  EXPECT_FALSE(policy().keep);
}

// A recording that a person skips: the robot was not seen to lie still in the time between.
TEST_F(OnClockTopic, AClockThatJumpsForwardsKeepsTheRemainingTime) {
  Clock(100);
  Motion(kLying);
  Clock(110);
  robot().Feed(event::ClockReceived{Time(std::chrono::seconds(710)), true});
  robot().RunFor(Milliseconds(500));
  EXPECT_EQ(state(), "Active");
  Clock(729);
  EXPECT_EQ(state(), "Active");
  Clock(730);
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(OnClockTopic, AClockThatJumpsForwardsEndsNoKeep) {
  Clock(100);
  KeepAndWait("Active", 30);
  robot().Feed(event::ClockReceived{Time(std::chrono::seconds(700)), true});
  robot().RunFor(Milliseconds(500));
  EXPECT_TRUE(policy().keep);
  Clock(730);
  EXPECT_FALSE(policy().keep);
}

TEST_F(OnClockTopic, TheFirstClockSampleDoesNotEndAKeep) {
  KeepAndWait("Active", 30);
  Clock(5000);
  EXPECT_TRUE(policy().keep);
  Clock(5030);
  EXPECT_FALSE(policy().keep);
}

// Nothing of an upgrade waits for a world whose clock stands still, or was never received.
TEST_F(OnClockTopic, AnUpgradeEntersAndLeavesOtaBySteadyTime) {
  EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, true), "ok");
  EXPECT_EQ(state(), "OTA");
  robot().RunFor(std::chrono::hours(1));
  EXPECT_EQ(state(), "OTA");
  robot().On("a", "Active").ends_when_requested = true;  // it does not come back by itself
  const RequestId leave = RequestPolicy(PolicyRequest::kOta, false);
  robot().RunFor(std::chrono::minutes(1));
  ASSERT_EQ(robot().calls.count(leave), 1U) << "the time limit of a step is of the steady clock";
  EXPECT_FALSE(robot().calls.at(leave));
}

class WithoutTheRule : public Rules {};

TEST_F(WithoutTheRule, NoMotionCountsAsLyingStill) {
  MachineConfig config = WithPolicy();
  config.policy->low_power.reset();
  Robot("Active", config);
  Motion(kLying);
  robot().RunFor(std::chrono::seconds(60));
  EXPECT_FALSE(policy().still);
  EXPECT_EQ(state(), "Active");
}

TEST_F(LyingStill, IsNoDeadlineWhileTheRobotIsAboutToBePoweredOff) {
  Motion(kLying);
  robot().RunFor(Milliseconds(29'900));
  RequestPolicy(PolicyRequest::kPowerOff);
  const auto next = NextDeadline(robot().config(), robot().machine());
  ASSERT_TRUE(next);
  EXPECT_GT(*next - robot().now(), Milliseconds(200));
}

}  // namespace musher::testing::lying_still_test
