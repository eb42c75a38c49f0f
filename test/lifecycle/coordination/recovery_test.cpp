// A crashed actuator is restarted by its policy and driven to the state of the machine; and what
// happens when that does not help.

#include <gmock/gmock.h>

#include "musher/lifecycle/switch/plan.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::recovery_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Recovery : public Switching {
 protected:
  // The time from its crash to its next start.
  static Duration DelayOfCrash(Harness& t, const std::string& name) {
    const Time begun = t.now();
    t.Crash(name);
    t.RunFor(Milliseconds(1));
    EXPECT_TRUE(t.RunUntil([&] { return t.IsAlive(name); }));
    const Duration delay = t.now() - begun;
    t.RunFor(Milliseconds(60));  // it is driven again
    return std::chrono::duration_cast<std::chrono::milliseconds>(delay);
  }
};

TEST_F(Recovery, DrivesACrashedActuatorThroughSetUpAndSelfCheckWhileTheOthersStay) {
  Harness& t = In("Protected", Ours(3));
  t.Crash("b");
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SelfCheck", "b:Protected"));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  EXPECT_EQ(t.machine().state, "Protected");
  const action::Record crashed = RecordWith(t.records, EventName::kActuatorCrashed);
  EXPECT_EQ(crashed.actuator, t.config().IndexOf("b"));
  EXPECT_NE(crashed.code, kCodeOk);
}

TEST_F(Recovery, DrivesItToTheStateThatTheMachineHasReachedMeanwhile) {
  Harness& t = In("Active", Ours(3));
  t.Crash("b");
  t.RunFor(Milliseconds(20));
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_THAT(t.log(), Not(Contains("b:Active")));
}

TEST_F(Recovery, DoesNotWaitForADetachedActuatorToBeInTheStateOfTheMachine) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "a").after = {"b"};
  Harness& t = In("Active", config);
  ASSERT_TRUE(t.Set("LowPower", "b").done());
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "Active");
}

TEST_F(Recovery, WaitsLongerBeforeEachRestartUpToACeiling) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.limit = 10;
  config.actuators[1].restart.max_delay = Milliseconds(500);
  Harness& t = In("Active", config);
  for (const int delay : {100, 200, 400, 500, 500}) {
    EXPECT_EQ(DelayOfCrash(t, "b"), Milliseconds(delay));
  }
}

TEST_F(Recovery, DelaysThatAreZeroStayZeroHoweverFastTheyGrow) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.limit = 400;
  config.actuators[1].restart.delay = {};
  config.actuators[1].restart.growth = 100;
  Harness& t = In("Active", config);
  for (int i = 0; i < 300; ++i) ASSERT_LE(DelayOfCrash(t, "b"), Milliseconds(1));
}

TEST_F(Recovery, ResetsTheCountAfterAHealthyTime) {
  Harness& t = In("Active", Ours(2));
  EXPECT_EQ(DelayOfCrash(t, "b"), Milliseconds(100));
  t.RunFor(Milliseconds(4800));
  EXPECT_EQ(DelayOfCrash(t, "b"), Milliseconds(200)) << "not yet";
  t.RunFor(Milliseconds(5200));
  EXPECT_EQ(DelayOfCrash(t, "b"), Milliseconds(100));
}

TEST_F(Recovery, TimeWithoutConnectionIsNotHealthyTime) {
  Harness& t = In("Active", Ours(2));
  DelayOfCrash(t, "b");
  t.Find("b", Health::kPartitioned, true);
  t.Rest();
  EXPECT_EQ(t.RecordOf("b").restart.count, 1);
}

TEST_F(Recovery, GivesUpAtTheLimitAndLeavesTheMachineDegraded) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "SetUp").code = 5012;
  t.On("b", "SetUp").message = "no sound card";
  t.Crash("b");
  t.Rest();
  EXPECT_TRUE(t.RecordOf("b").restart.given_up);
  const RecordText failed = texts::SetUpFailed(5012, "no sound card");
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::GivenUp("b", 3, failed.message)));
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SetUp", "b:SetUp"));
  EXPECT_EQ(t.machine().state, "Active");
}

TEST_F(Recovery, ACriticalActuatorOutOfRestartsTakesTheMachineToItsOnLostAndNotBefore) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "SetUp").code = 3012;
  t.Crash("b");
  t.RunFor(Milliseconds(500));
  EXPECT_EQ(t.machine().state, "Active") << "it still has a chance";
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("a"), "Protected");
  EXPECT_THAT(t.Set("Active").reason, HasSubstr("critical b"));
}

TEST_F(Recovery, ACriticalActuatorThatCrashesWhileItJoinsIsOnlyRestarted) {
  Harness& t = In("Active", OursWithCriticalB());
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").command.has_value(); }));
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Recovery, ACriticalActuatorThatFailsItsSelfCheckAfterARestartTakesTheMachineDown) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "SelfCheck").code = 3009;
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.RecordOf("b").fault->code, 3009);
}

TEST_F(Recovery, ACriticalActuatorWhoseSecondSetUpNeverEndsTakesTheMachineDown) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "SetUp").hangs = true;
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(Recovery, AnExplicitOnLostAppliesToANonCriticalActuator) {
  MachineConfig config = MachineOf(2);
  config.actuators[1].on_lost = "LowPower";
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kDoneDegraded) << "an operator may continue";
}

TEST_F(Recovery, TheFlowOfTheConfigForbidsNoFallback) {
  MachineConfig config = MachineOf(2);
  config.actuators[1].on_lost = "LowPower";
  std::erase_if(config.flow, [](const FlowEdge& edge) { return edge.to == "LowPower"; });
  Harness& t = In("Active", config);
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kRefused)
      << "an operator's request is executed";
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
}

TEST_F(Recovery, OfSeveralLostOnesTheLeastActiveOnLostCounts) {
  MachineConfig config = MachineOf(3);
  config.actuators[1].on_lost = "Protected";
  config.actuators[2].on_lost = "LowPower";
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Crash("c");
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
}

// Policies

TEST_F(Recovery, OnFailureDoesNotRestartAfterExitCodeZeroButAlwaysDoes) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kAlways;
  Harness& t = In("Active", config);
  for (const char* name : {"a", "b"}) {
    t.Feed(event::ProcessEnded{*config.IndexOf(name), t.RecordOf(name).process.pid, true,
                               "exit code 0"});
  }
  t.RunFor(Milliseconds(50));
  EXPECT_FALSE(t.RecordOf("a").restart.at);
  EXPECT_THAT(t.RecordOf("a").fault, Is(EventName::kActuatorExited));
  EXPECT_TRUE(t.RecordOf("b").restart.at);
}

TEST_F(Recovery, NoMeansNo) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
}

TEST_F(Recovery, AnActuatorTornDownByRequestStaysDown) {
  MachineConfig config = Ours(2);
  config.actuators[1].restart.policy = RestartPolicy::kAlways;
  Harness& t = In("Active", config);
  EXPECT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
  t.Restart("b");
  t.RunFor(Milliseconds(1));
  t.Crash("b");  // before its first status
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active") << "that it was torn down is over since it was started";
}

TEST_F(Recovery, AProcessThatCannotBeStartedIsRetriedByTheSamePolicy) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "exec").code = kCodeFailed;
  t.On("b", "exec").message = "no such file";
  t.Crash("b");
  t.RunFor(Milliseconds(350));
  EXPECT_EQ(t.RecordOf("b").restart.count, 3);
  t.On("b", "exec").code = kCodeOk;
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Recovery, AnActuatorThatAnotherPartyRestartsInALoopIsNotDrivenForAWhile) {
  MachineConfig config = MachineOf(2);
  config.actuators[1].restart.limit = 3;
  config.actuators[1].restart.reset_after = std::chrono::seconds(5);
  Harness& t = In("Active", config);
  for (int i = 0; i < 5; ++i) {
    t.Crash("b");
    t.RunFor(Milliseconds(1));
    t.StartActuator("b");
    t.RunFor(Milliseconds(20));
  }
  t.ClearLog();
  t.RunFor(std::chrono::seconds(4));
  EXPECT_THAT(t.log(), ElementsAre()) << "it is not driven";
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::RestartedTooOften(5, std::chrono::seconds(5))));
  t.RunFor(std::chrono::seconds(2));
  EXPECT_EQ(t.StateOf("b"), "Active") << "it has run for long enough";
}

TEST_F(Recovery, AReconnectionIsNotCountedAsARestart) {
  MachineConfig config = MachineOf(2);
  config.actuators[1].restart.limit = 3;
  Harness& t = In("Active", config);
  t.Crash("b");
  t.RunFor(Milliseconds(1));
  t.StartActuator("b");
  t.RunFor(Milliseconds(100));
  for (int i = 0; i < 10; ++i) {
    t.Find("b", Health::kPartitioned, true);
    t.RunFor(Milliseconds(50));
    t.Find("b", Health::kWell);
    t.RunFor(Milliseconds(50));
  }
  EXPECT_FALSE(t.RecordOf("b").restart.given_up);
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// Samples that come late, or twice

TEST_F(Recovery, ALateLossOfAWriterDoesNotCountForTheSuccessor) {
  Harness& t = In("Active", OursWithCriticalB());
  const Incarnation dead = t.RecordOf("b").report.incarnation;
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] {
    return t.RecordOf("b").process.pid != 0 && t.IsAlive("b") &&
           t.RecordOf("b").presence == Presence::kStarting;
  }));
  t.Feed(event::Vanished{1, dead, false, "connection lost"});
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Recovery, AnExitThatFollowsALostConnectionDoesNotTakeTheMachineDown) {
  Harness& t = In("Active", OursWithCriticalB());
  t.Feed(event::Vanished{1, t.RecordOf("b").report.incarnation, false, "connection lost"});
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Recovery, TheEndOfAWrapperAndOfItsActuatorIsOneLoss) {
  Harness& t = In("Active", Ours(2));
  ActuatorReport report = t.CoreOf("b").report;
  report.incarnation += 1'000'000;  // the command is a script; this is its child
  report.pid += 1'000'000;
  report.stamp = t.now();
  t.Feed(event::StatusSeen{1, report});
  const std::int32_t wrapper = t.RecordOf("b").process.pid;
  ASSERT_NE(wrapper, 0);
  t.Feed(event::Vanished{1, report.incarnation, true, "its process ended"});
  t.Feed(event::ProcessEnded{1, wrapper, false, "exit code 1"});
  EXPECT_EQ(t.RecordOf("b").restart.count, 1);
}

TEST_F(Recovery, AMachineThatLeavesErrorDoesNotFallBackFromItsSelfCheck) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  Harness& t = In("Error", config);
  ASSERT_TRUE(t.Set("SelfCheck").done());
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "SelfCheck");
}

TEST_F(Recovery, ARestartedActuatorThatFailsToFollowIsNotDrivenAgainByItself) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "Active").code = 3001;
  t.Crash("b");
  t.RunFor(std::chrono::seconds(10));  // its restarts are no longer counted by then
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SelfCheck", "b:Active"));
}

// Which no checked config has: its on_lost is one of its states.
TEST_F(Recovery, AFallbackToAStateThatTheMachineDoesNotHaveIsRefusedAndRecorded) {
  MachineConfig config = OursWithCriticalB();
  std::erase(config.states, State("Protected"));
  Harness& t = In("Active", config);
  t.Exit("b", 2, "no licence");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  const Plan refused = MakePlan(t.config(), t.machine(), State("Protected"));
  EXPECT_EQ(refused.refusal.value().code, kCodeParametersInvalid) << "unknown";
  EXPECT_THAT(t.records,
              Contains(Is(texts::FallbackRefused("Protected", refused.refusal.value().message))));
}

TEST_F(Recovery, OfAProcessThatHangsInItsSetUpIsGivenUpForThatAndNotForTheCrashBefore) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "SetUp").hangs = true;
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.IsAlive("b"); }));
  t.RunFor(Milliseconds(150));
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->event, EventName::kSetUpTimeout);
}

TEST_F(Recovery, OfAnActuatorWithoutTheStateOfTheMachineEndsWithThatCode) {
  MachineConfig config = Ours(2);
  std::erase(ActuatorNamed(config, "b").states, "LowPower");
  ActuatorNamed(config, "b").times.pop_back();
  Harness& t = In("Active", config);
  t.Set("LowPower");
  t.Crash("b");
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->code, kCodeUnSupport);
}

}  // namespace musher::testing::recovery_test
