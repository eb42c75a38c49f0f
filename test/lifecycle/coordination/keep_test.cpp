// A machine that is kept in a state for a while, regardless of the rules.

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::keep_test {

using ::testing::ElementsAre;
using ::testing::StartsWith;

class KeepRule : public Rules {};

TEST_F(KeepRule, WithTicksTheStateIsTakenAndKept) {
  Robot();
  EXPECT_EQ(KeepAndWait("Protected", 60), "ok");
  EXPECT_EQ(state(), "Protected");
  ASSERT_TRUE(policy().keep);
  robot().RunFor(std::chrono::seconds(57));
  EXPECT_TRUE(policy().keep);
  robot().RunFor(std::chrono::seconds(2));
  EXPECT_FALSE(policy().keep);
  EXPECT_EQ(state(), "Protected") << "its end changes no state";
  EXPECT_THAT(robot().whole_records.back(), Is(texts::KeepEnded("Protected", "time expired")));
  EXPECT_EQ(robot().whole_records.back().code, kCodeOk);
}

TEST_F(KeepRule, WithoutTicksTheStateIsTakenOnce) {
  Robot();
  EXPECT_EQ(KeepAndWait("Protected", 0), "ok");
  EXPECT_EQ(state(), "Protected");
  EXPECT_FALSE(policy().keep);
}

TEST_F(KeepRule, AnAbsurdNumberOfSecondsIsRefused) {
  Robot();
  EXPECT_EQ(KeepAndWait("Protected", INT64_MAX),
            "110: a keep lasts 0 to 31536000 s, not 9223372036854775807 s");
  EXPECT_FALSE(policy().keep);
  EXPECT_EQ(KeepAndWait("Protected", 31536000), "ok");
}

TEST_F(KeepRule, ZeroTicksEndAKeepAndChangeNoState) {
  Robot();
  KeepAndWait("Protected", 60);
  EXPECT_EQ(KeepAndWait("LowPower", 0), "ok");
  EXPECT_FALSE(policy().keep);
  EXPECT_EQ(state(), "Protected");
}

TEST_F(KeepRule, TheEndOfAMissingKeepIsRefused) {
  Robot();
  EXPECT_EQ(KeepAndWait("", 0), "103: nothing keeps the machine in Active");
  EXPECT_EQ(state(), "Active");
}

// The replaced code answered success, with code -1.
TEST_F(KeepRule, ASecondKeepIsRefusedAndNotCalledASuccess) {
  Robot();
  KeepAndWait("Protected", 60);
  EXPECT_EQ(KeepAndWait("Active", 10),
            "103: the machine is kept in Protected for another 58 s; end it with "
            "`musher keep --end`");
  EXPECT_EQ(state(), "Protected");
}

TEST_F(KeepRule, TheBatteryRuleDoesNotApplyMeanwhileAndAppliesAfterwards) {
  Robot();
  EXPECT_EQ(KeepAndWait("Active", 30), "ok");
  Battery(3);
  EXPECT_EQ(state(), "Active");
  EXPECT_TRUE(robot().Set("Active").done()) << "nor in what people request";
  Battery(0);
  EXPECT_EQ(state(), "Active");
  Battery(3);
  robot().RunFor(std::chrono::seconds(30));
  EXPECT_EQ(state(), "LowPower");
}

// Found by simulation: the rule had tried to raise the machine, which one actuator makes
// impossible. Its lowering then waited for the next attempt, up to a minute.
TEST_F(KeepRule, TheBatteryRuleAppliesAfterwardsAtOnceWhereItsRaiseWasRefusedBefore) {
  MachineConfig config = WithPolicy();
  std::erase(ActuatorNamed(config, "b").states, "Protected");
  Robot("Active", config);
  Battery(3);
  ASSERT_EQ(state(), "LowPower");
  Battery(20);
  robot().RunFor(std::chrono::minutes(3));
  ASSERT_EQ(state(), "LowPower") << "b has no Protected";
  ASSERT_TRUE(policy().retry_at);
  EXPECT_EQ(KeepAndWait("Active", 4), "ok");
  EXPECT_EQ(state(), "Active");
  robot().RunFor(Milliseconds(2100));
  EXPECT_EQ(state(), "Protected");
}

TEST_F(KeepRule, ASwitchToAnotherStateEndsTheKeepAndReportsIt) {
  Robot();
  KeepAndWait("Active", 60);
  Battery(10);
  const SwitchResult result = robot().Set("DeActive");
  EXPECT_TRUE(result.done());
  EXPECT_EQ(result.reason, "the machine is no longer kept in Active");
  EXPECT_FALSE(policy().keep);
  EXPECT_THAT(robot().Set("Active").reason, StartsWith("the battery is at 10 %"));
}

TEST_F(KeepRule, ASwitchElsewhereThatIsUndoneLeavesTheKeep) {
  Robot();
  KeepAndWait("Protected", 60);
  robot().On("a", "Active").code = 3009;
  EXPECT_EQ(robot().Set("Active").outcome, SwitchOutcome::kUndone);
  EXPECT_TRUE(policy().keep);
}

TEST_F(KeepRule, ASwitchToThatStateAndASwitchOfOneActuatorLeaveTheKeep) {
  Robot();
  KeepAndWait("Active", 60);
  EXPECT_EQ(robot().Set("Active").reason, "");
  EXPECT_TRUE(robot().Set("DeActive", "a").done());
  EXPECT_TRUE(policy().keep);
}

TEST_F(KeepRule, ASelfCheckLeavesTheKeep) {
  Robot();
  KeepAndWait("Active", 60);
  EXPECT_EQ(robot().Set("SelfCheck").reason, "");
  EXPECT_TRUE(policy().keep);
}

TEST_F(KeepRule, AboveTheCeilingOnlyTheKeptStateIsOpen) {
  Robot();
  Battery(3);
  KeepAndWait("Protected", 60);
  EXPECT_THAT(robot().Set("Active").reason, StartsWith("the battery is at 3 %"));
  EXPECT_TRUE(policy().keep);
}

TEST_F(KeepRule, MayRaiseTheMachineAboveTheCeilingUntilItIsOver) {
  Robot();
  Battery(10);
  EXPECT_EQ(KeepAndWait("Active", 10), "ok");
  EXPECT_EQ(state(), "Active");
  robot().RunFor(std::chrono::seconds(10));
  EXPECT_THAT(states(), ElementsAre("Active", "Protected", "Active", "Protected"));
  Battery(90);
  EXPECT_EQ(state(), "Active") << "it was the battery that took it down";
}

TEST_F(KeepRule, WithoutTicksTheCeilingHolds) {
  Robot();
  Battery(10);
  EXPECT_THAT(KeepAndWait("Active", 0), StartsWith("113: the battery is at 10 %"));
}

TEST_F(KeepRule, WakeUpOtaAndPowerOffAreRefusedMeanwhile) {
  Robot("LowPower");
  EXPECT_EQ(KeepAndWait("LowPower", 60), "ok");
  for (const auto what : {PolicyRequest::kWakeUp, PolicyRequest::kOta, PolicyRequest::kPowerOff,
                          PolicyRequest::kReboot}) {
    EXPECT_THAT(RequestAndWait(what, true), StartsWith("103: the machine is kept in LowPower"));
  }
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(KeepRule, LyingStillDoesNotCountMeanwhile) {
  Robot();
  RequestPolicy(PolicyRequest::kLowPowerSwitch, true);
  KeepAndWait("Active", 60);
  Motion(101);
  robot().RunFor(std::chrono::seconds(59));
  EXPECT_EQ(state(), "Active");
  robot().RunFor(std::chrono::seconds(28));
  EXPECT_EQ(state(), "Active") << "it counts from the end of the keep";
  robot().RunFor(std::chrono::seconds(4));
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(KeepRule, AnUndoneSwitchIsNotKept) {
  Robot("Protected");
  robot().On("a", "Active").code = 3009;
  EXPECT_THAT(KeepAndWait("Active", 60), StartsWith("3009: "));
  EXPECT_FALSE(policy().keep);
}

TEST_F(KeepRule, ARefusedSwitchIsNotKept) {
  Robot();
  EXPECT_THAT(KeepAndWait("Resting", 60), StartsWith("110: unknown state 'Resting'"));
  EXPECT_FALSE(policy().keep);
  EXPECT_EQ(KeepAndWait("Active", -1), "110: a keep lasts 0 to 31536000 s, not -1 s");
}

TEST_F(KeepRule, ASwitchSupersededByErrorIsNotKept) {
  Robot("Protected");
  robot().On("a", "Active").takes = Milliseconds(80);
  const RequestId request = Keep("Active", 60);
  EXPECT_EQ(robot().Set("Error").reason, "") << "it ends no keep: that was over before";
  EXPECT_THAT(Text(robot().calls.at(request)), StartsWith("111: "));
  EXPECT_FALSE(policy().keep);
  EXPECT_TRUE(IsRecorded(texts::KeepEnded("Active", "the switch to it was superseded")));
}

TEST_F(KeepRule, AKeepInAStepOfAStartByHandEndsInTimeToo) {
  Harness t(WithPolicy());
  t.Begin(/*by_hand=*/true);
  t.Rest();
  t.SendPolicyRequest({0, PolicyRequest::kKeep, "SelfCheck", 5, false});
  t.RunFor(std::chrono::seconds(4));
  EXPECT_EQ(t.machine().phase, Phase::kStarting);
  EXPECT_TRUE(t.machine().policy.keep);
  t.RunFor(std::chrono::seconds(2));
  EXPECT_FALSE(t.machine().policy.keep);
}

using KeepAndTearDown = OneController;

// The rules do not apply any more then: the end of the keep stayed the next deadline.
TEST_F(KeepAndTearDown, TheEndOfAKeepIsNoDeadlineOfATearDown) {
  config_.policy.emplace();
  StartUp();
  Do(event::PolicyRequested{1, PolicyRequest::kKeep, "LowPower", 1, false});
  ObeyAll();
  const Time until = machine_.policy.keep.value().until;
  Do(event::SetStateRequested{2, "TearDown", {}});
  now_ = until;
  Do(event::TimePassed{});
  ASSERT_EQ(machine_.phase, Phase::kStopping);
  EXPECT_GT(Next(), now_) << "the loop would spin";
}

TEST_F(KeepRule, LastsItsTimeThoughAClockIsReceivedThatTheConfigDoesNotName) {
  Robot();
  KeepAndWait("Protected", 60);
  robot().Feed(event::ClockReceived{Time(std::chrono::hours(5))});
  robot().RunFor(std::chrono::seconds(60));
  EXPECT_FALSE(policy().keep);
}

TEST_F(KeepRule, EndsInTimeAlsoWhereTheStartHasFailed) {
  Harness t(WithPolicy());
  t.disk().stops.engaged = {{7, "a panel", ""}};
  t.Begin();
  t.Rest();
  t.Release();
  t.RunFor(Milliseconds(10));
  t.SendPolicyRequest({0, PolicyRequest::kKeep, "SelfCheck", 60, false});
  t.RunFor(std::chrono::seconds(59));
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_TRUE(t.machine().policy.keep);
  t.RunFor(std::chrono::seconds(2));
  EXPECT_FALSE(t.machine().policy.keep);
}

}  // namespace musher::testing::keep_test
