#include "musher/lifecycle/machine/timed_rule_check.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::timed_rule_check_test {

// "within 2 s of LowPower a in LowPower or exited"
class ARuleWithATime : public ::testing::Test {
 protected:
  ARuleWithATime() {
    rule_.within = std::chrono::seconds(2);
    rule_.of = State("LowPower");
    rule_.subject = ActuatorIndex(0);
    rule_.states = {State("LowPower"), State()};
  }
  bool IsViolatedAt(std::int64_t ms, const State& goal, const std::optional<State>& state) {
    return check_.Update(rule_, goal, state, Time() + Milliseconds(ms));
  }

  TimedRule rule_;
  TimedRuleCheck check_;
};

TEST_F(ARuleWithATime, IsMetByAStateInTime) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", State("Active")));
  EXPECT_EQ(check_.due(), std::optional(Time() + std::chrono::seconds(2)));
  EXPECT_FALSE(IsViolatedAt(2000, "LowPower", State("LowPower")));
  EXPECT_EQ(check_.due(), std::nullopt);
  EXPECT_FALSE(IsViolatedAt(9000, "LowPower", State("Active"))) << "it says nothing of later";
  EXPECT_EQ(check_.coverage().begun, 1U);
  EXPECT_EQ(check_.coverage().met, 1U);
}

TEST_F(ARuleWithATime, IsMetByAProcessThatHasExitedWhereItSaysSo) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", State()));
  EXPECT_EQ(check_.coverage().met, 1U);
}

TEST_F(ARuleWithATime, IsViolatedOnceItsTimeIsOver) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", State("Active")));
  EXPECT_FALSE(IsViolatedAt(1999, "LowPower", State("Active")));
  EXPECT_TRUE(IsViolatedAt(2000, "LowPower", State("Active")));
  EXPECT_TRUE(check_.is_violated());
  EXPECT_FALSE(IsViolatedAt(3000, "LowPower", State("Active"))) << "it was reported";
  EXPECT_TRUE(check_.is_violated());
  EXPECT_FALSE(IsViolatedAt(4000, "LowPower", State("LowPower")));
  EXPECT_FALSE(check_.is_violated());
  EXPECT_EQ(check_.coverage().met, 0U);
}

// An event may come before the timer of due().
TEST_F(ARuleWithATime, IsViolatedByAStateThatComesLate) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", State("Active")));
  EXPECT_TRUE(IsViolatedAt(2001, "LowPower", State("LowPower")));
  EXPECT_FALSE(check_.is_violated()) << "it is there now";
}

TEST_F(ARuleWithATime, CountsNoMoreOnceTheMachineGoesElsewhere) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", State("Active")));
  EXPECT_FALSE(IsViolatedAt(1000, "Active", State("Active")));
  EXPECT_EQ(check_.due(), std::nullopt);
  EXPECT_FALSE(IsViolatedAt(9000, "LowPower", State("Active"))) << "its time begins again";
  EXPECT_EQ(check_.due(), std::optional(Time() + std::chrono::seconds(11)));
  EXPECT_EQ(check_.coverage().begun, 2U);
}

TEST_F(ARuleWithATime, WaitsUntilTheStateIsKnown) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", std::nullopt));
  EXPECT_FALSE(IsViolatedAt(2000, "LowPower", std::nullopt));
  EXPECT_EQ(check_.due(), std::nullopt) << "no timer for a time that has passed";
  EXPECT_TRUE(IsViolatedAt(3000, "LowPower", State("Active")));
}

// It may have been there in time.
TEST_F(ARuleWithATime, IsNotViolatedByWhatWasNotSeen) {
  EXPECT_FALSE(IsViolatedAt(0, "LowPower", State("Active")));
  EXPECT_FALSE(IsViolatedAt(1000, "LowPower", std::nullopt));
  EXPECT_FALSE(IsViolatedAt(3000, "LowPower", State("LowPower")));
  EXPECT_FALSE(check_.is_violated());
}

class TheGoalOfAMachine : public Switching {
 protected:
  static std::optional<State> Of(const Harness& t) { return GoalOf(t.config(), t.machine()); }
  static std::optional<State> A(const char* state) { return State(state); }
};

TEST_F(TheGoalOfAMachine, IsTheTargetOfItsSwitchElseItsState) {
  Harness& t = In("Active", Ours(2));
  EXPECT_EQ(Of(t), A("Active"));
  t.RequestSwitch("LowPower");
  ASSERT_TRUE(t.machine().current);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(Of(t), A("LowPower"));
  Machine undone = t.machine();
  undone.current->rollback.under_way = true;
  EXPECT_EQ(GoalOf(t.config(), undone), A("Active"));
  t.Rest();
  EXPECT_EQ(Of(t), A("LowPower"));
}

TEST_F(TheGoalOfAMachine, StaysInASwitchOfOneActuatorAndInACheck) {
  Harness& t = In("Active", Ours(2));
  t.RequestSwitch("LowPower", "a");
  ASSERT_TRUE(t.machine().current);
  EXPECT_EQ(Of(t), A("Active"));
  t.Rest();
  t.RequestSwitch("SelfCheck");
  ASSERT_TRUE(t.machine().current);
  EXPECT_EQ(Of(t), A("Active"));
}

TEST_F(TheGoalOfAMachine, IsNoneBeforeItsStartAndOnceItIsTornDown) {
  Harness robot(Ours(2));
  EXPECT_EQ(Of(robot), std::nullopt);
  robot.Begin();
  robot.Rest();
  robot.RequestSwitch("TearDown");
  EXPECT_EQ(Of(robot), A("TearDown"));
  robot.Rest();
  ASSERT_EQ(robot.machine().phase, Phase::kStopped);
  EXPECT_EQ(Of(robot), std::nullopt);
}

}  // namespace musher::testing::timed_rule_check_test
