// A hung process gets a backtrace, is killed and restarted if this controller has started it, and
// is listed where not.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::hang_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;

class Hang : public Switching {};

TEST_F(Hang, LeavesABacktraceThenTheProcessIsKilledRestartedAndDrivenAgain) {
  Harness& t = In("Active", Ours(2));
  t.Find("b", Health::kHung);
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kLost);
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::Unhealthy(Health::kHung, "as the test says")));
  t.RunFor(Milliseconds(49));
  EXPECT_THAT(t.signals, ElementsAre()) << "it is being looked at";
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre("b:KILL"));
  EXPECT_THAT(t.records, Contains(Is(texts::BacktraceTaken("b"))));
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SelfCheck", "b:Active"));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Hang, IsKilledThoughThereIsNoBacktrace) {
  Harness& t = In("Active", Ours(2));
  t.Find("b", Health::kHung, true);
  t.Feed(event::BacktraceTaken{1, 1, "of some other process"});
  EXPECT_THAT(t.signals, ElementsAre());
  t.RunFor(std::chrono::seconds(6));
  EXPECT_THAT(t.signals, ElementsAre("b:KILL"));
}

TEST_F(Hang, ThatEndsBeforeTheKillIsCancelled) {
  Harness& t = In("Active", Ours(2));
  t.Find("b", Health::kHung, true);
  t.RunFor(Milliseconds(20));
  t.Find("b", Health::kWell);
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre());
  EXPECT_THAT(t.log(), ElementsAre()) << "it is where it was";
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  EXPECT_EQ(t.RecordOf("b").restart.count, 0);
}

// The exit of a process can be seen after the first status of its successor.
TEST_F(Hang, WhoseSuccessorIsPresentIsNotAssumedToHaveExited) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "KILL").hangs = true;
  t.Find("b", Health::kHung, true);
  t.RunFor(Milliseconds(60));
  EXPECT_THAT(t.signals, ElementsAre("b:KILL"));
  t.StartActuator("b");  // by a person, before the restart
  t.Rest();
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kProcessExitAssumed))));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Hang, CountsAsARestartAndEndsAtTheLimit) {
  Harness& t = In("Active", OursWithCriticalB());
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(t.machine().state, "Active");
    t.Find("b", Health::kHung);
    t.RunFor(std::chrono::seconds(1));
  }
  t.Rest();
  EXPECT_TRUE(t.RecordOf("b").restart.given_up);
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(Hang, WithoutARestartPolicyIsListedAndTheProcessLeftAsItIs) {
  MachineConfig config = OursWithCriticalB();
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Find("b", Health::kHung);
  t.RunFor(std::chrono::seconds(10));
  EXPECT_THAT(t.signals, ElementsAre());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_EQ(t.machine().state, "Protected") << "it is critical and not restarted";
}

TEST_F(Hang, OfAProcessOfAnotherPartyIsListedUntilItEnds) {
  Harness& t = In("Active");
  t.Find("b", Health::kHung);
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  t.Find("b", Health::kWell);
  t.Rest();
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Hang, OfAnAdoptedProcessIsKilledAndRestartedAsWell) {
  Harness& t = In("Active", Ours(2));
  t.RestartController();
  t.Rest();
  ASSERT_EQ(t.RecordOf("b").process.launch, Launch::kFoundRunning) << "adopted";
  t.Find("b", Health::kHung, true);
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre("b:KILL"));
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_NE(t.RecordOf("b").process.pid, 0);
}

TEST_F(Hang, OfAProcessThatSigkillDoesNotEndIsAssumedToHaveExitedAfterAWhile) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "KILL").hangs = true;  // its driver never returns
  t.On("b", "exec").code = kCodeFailed;
  t.Find("b", Health::kHung, true);
  t.Rest();
  EXPECT_THAT(t.records, Contains(Is(EventName::kProcessExitAssumed)));
  EXPECT_TRUE(t.RecordOf("b").restart.given_up);
  EXPECT_EQ(t.machine().state, "Protected") << "and not: waited for in Active for ever";
}

TEST_F(Hang, InASwitchUpUndoesItAndTheRestartedActuatorFollows) {
  Harness& t = In("Protected", Ours(3));
  t.On("b", "Active").hangs = true;
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(30));
  t.Find("b", Health::kHung);
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected");
}

TEST(HangInSetUp, IsRestartedWhileTheStartWaits) {
  MachineConfig config = OursWithCriticalB(2);
  config.actuators[1].checkpoint = Milliseconds(50);
  Harness t(config);
  t.On("b", "SetUp").hangs = true;
  t.Begin();
  t.RunFor(Milliseconds(60));
  t.Find("b", Health::kHung);
  t.On("b", "SetUp").hangs = false;
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Hang, AStarvedProcessIsRecordedAndNotKilled) {
  Harness& t = In("Active", OursWithCriticalB());
  t.Find("b", Health::kStarved, true);
  t.Rest();
  EXPECT_THAT(t.records, Contains(Is(texts::ActuatorStarved("b", "as the test says"))));
  EXPECT_THAT(t.signals, ElementsAre());
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  EXPECT_TRUE(t.Set("LowPower").done());
}

TEST_F(Hang,
       ADisconnectedCriticalActuatorOfAnotherHostTakesTheMachineDownAndJoinsAfterReconnection) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  Harness& t = In("Active", config);
  t.Find("b", Health::kPartitioned, true);
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("b"), "Active") << "it cannot be reached";
  t.Find("b", Health::kWell);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected");
  EXPECT_TRUE(t.Set("Active").done());
}

TEST_F(Hang, VerdictsOfAProcessThatHasExitedChangeNothing) {
  Harness& t = In("Active", Ours(2));
  const Incarnation gone = t.RecordOf("b").report.incarnation;
  t.Crash("b");
  t.Rest();
  t.signals.clear();
  t.Feed(event::HealthChanged{1, gone, Health::kHung, true, "late"});
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre());
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kCommandFailed))));
}

TEST_F(Hang, ThatEndsAfterTheKillWasSentIsOverToo) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "KILL").hangs = true;
  t.Find("b", Health::kHung, true);
  t.RunFor(Milliseconds(60));
  t.Find("b", Health::kWell);
  t.Rest();
  EXPECT_THAT(t.signals, ElementsAre("b:KILL"));
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Hang, OfAnActuatorThatALateOneNeedsDelaysItUntilTheHangEnds) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "a").after = {"b"};
  Harness& t = In("Active", config);
  t.Find("b", Health::kHung);
  t.Crash("a");
  t.RunFor(Milliseconds(1));
  t.StartActuator("a");
  t.RunFor(Milliseconds(100));
  EXPECT_EQ(t.StateOf("a"), "SetUp");
  t.Find("b", Health::kWell);
  t.RunFor(Milliseconds(100));
  EXPECT_EQ(t.StateOf("a"), "Active");
}

TEST_F(Hang, WhoseBacktraceComesAfterTheKillIsNotKilledAgain) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "KILL").hangs = true;
  t.Find("b", Health::kHung, true);
  ASSERT_TRUE(t.RunUntil([&] { return !t.signals.empty(); }));
  const std::int32_t pid = t.RecordOf("b").process.termination.value().pid;
  const auto kill_at = t.RecordOf("b").process.termination->kill_at;
  const std::size_t records = t.records.size();
  t.Feed(event::BacktraceTaken{1, pid, "late"});
  EXPECT_THAT(t.signals, ElementsAre("b:KILL"));
  EXPECT_EQ(t.RecordOf("b").process.termination.value().kill_at, kill_at);
  EXPECT_EQ(t.records.size(), records);
}

}  // namespace musher::testing::hang_test
