// Faults found by random scenarios (test/simulation), each reduced to a minimal case.

#include <gmock/gmock.h>

#include <algorithm>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::found_by_simulation_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class FoundBySimulation : public Switching {
 protected:
  static void Unlist(MachineConfig& config, const std::string& name, const State& state) {
    ActuatorConfig& actuator = ActuatorNamed(config, name);
    const auto at = std::find(actuator.states.begin(), actuator.states.end(), state);
    actuator.times.erase(actuator.times.begin() + (at - actuator.states.begin()));
    actuator.states.erase(at);
  }
};

TEST_F(FoundBySimulation, ARollbackTakesNoActuatorAboveTheMachine) {
  MachineConfig config = MachineOf(2);
  Unlist(config, "a", "LowPower");  // so it stays in Active when the machine goes to LowPower
  Harness& t = In("Active", config);
  t.Set("LowPower");
  ASSERT_EQ(t.StateOf("a"), "Active");
  t.On("b", "Protected").code = 5001;
  t.On("b", "Protected").takes = Milliseconds(50);
  t.ClearLog();
  EXPECT_EQ(t.Set("Protected").outcome, SwitchOutcome::kUndone);
  t.Rest();
  EXPECT_THAT(t.log(), Not(Contains("a:Active")));
  EXPECT_EQ(t.StateOf("a"), "Protected");
}

TEST_F(FoundBySimulation, ACriticalActuatorOfALaterStageThatIsNeverStartedCountsAsLost) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").stage = 2;
  ActuatorNamed(config, "b").after = {"a"};
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  ActuatorNamed(config, "a").restart.policy = RestartPolicy::kNo;
  Harness t(config);
  t.On("a", "SelfCheck").code = 5001;
  t.Begin();
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
  EXPECT_NE(t.machine().state, "Active");
}

TEST_F(FoundBySimulation, AnActuatorBlockedByAnotherIsStartedWhenThatActuatorIsPresent) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "a").command.clear();  // started by hand, and late
  ActuatorNamed(config, "b").after = {"a"};
  Harness t(config);
  t.On("a", "exec").code = kCodeFailed;
  t.Begin();
  t.Crash("a");
  t.Rest();
  ASSERT_FALSE(t.IsAlive("b"));
  EXPECT_THAT(t.RecordOf("b").fault,
              Is(texts::DependencyDegraded("a", t.RecordOf("a").fault->message)));
  t.StartActuator("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(FoundBySimulation, AnActuatorThatWaitsForASuspendedActuatorReportsThat) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "b").binds_to = {"a"};
  ActuatorNamed(config, "c").after = {"b"};
  ActuatorNamed(config, "a").restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  t.Crash("a");  // b is suspended …
  t.Rest();
  t.Crash("c");  // … and c cannot come back before it
  t.Rest();
  ASSERT_TRUE(t.RecordOf("c").fault);
  EXPECT_THAT(t.RecordOf("c").fault, Is(texts::DependencySuspended("b")));
}

TEST_F(FoundBySimulation, TearDownOfAnActuatorBeforeTheMachineIsSetUpIsRefused) {
  Harness t(Ours(2));
  t.On("a", "SetUp").takes = Milliseconds(80);
  t.Begin();
  t.RunUntil([&] { return t.RecordOf("b").presence == Presence::kPresent; });
  const RequestId request = t.RequestSwitch("TearDown", "b");
  t.Rest();
  ASSERT_EQ(t.answers.count(request), 1U);
  EXPECT_EQ(t.answers[request].outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(t.machine().state, "Active");
}

TEST_F(FoundBySimulation, ACriticalActuatorTornDownAloneCountsAsLostFromTheNextSwitchOn) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "a").on_lost = "Protected";
  Harness& t = In("Active", config);
  t.Set("TearDown", "a");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");  // as intended
  t.Set("Active");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(FoundBySimulation, ACheckThatEndsAfterItsSwitchWasSupersededCounts) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "a").critical = true;
  Harness t(config);
  t.On("a", "SelfCheck").code = 5001;
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  t.On("a", "SelfCheck") = {};
  t.On("a", "SelfCheck").takes = Milliseconds(60);
  t.Mute("a", false, true);  // the report that it is busy with its check is lost
  t.RequestSwitch("SelfCheck");
  t.RunFor(Milliseconds(20));
  const RequestId error = t.RequestSwitch("Error");
  t.RunFor(Milliseconds(20));
  t.Mute("a", false, false);
  t.Rest();
  EXPECT_EQ(t.answers[error].state, "Error");
  EXPECT_EQ(t.StateOf("a"), "Error");
}

TEST_F(FoundBySimulation, ARollbackTakesNoActuatorHigherThanTheSwitchHad) {
  MachineConfig config = Ours(2);
  Unlist(config, "a", "OTA");
  Harness& t = In("Active", config);
  t.Set("OTA");
  t.Crash("a");  // so it comes back to a step of a start, and has no OTA to join
  t.Rest();
  ASSERT_FALSE(t.config().RankOf(t.StateOf("a")));
  t.On("b", "LowPower").code = 5001;
  t.On("b", "LowPower").takes = Milliseconds(50);
  t.ClearLog();
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kUndone);
  t.Rest();
  EXPECT_THAT(t.log(), Not(Contains("a:DeActive")));
}

// It stood above the machine, and was brought to the target of the switch up that had failed.
TEST_F(FoundBySimulation, ARollbackLeavesAnActuatorThatCouldNotComeDownWhereItWas) {
  MachineConfig config = Ours(2);
  Unlist(config, "a", "LowPower");
  Harness& t = In("DeActive", config);
  t.Set("LowPower");
  ASSERT_EQ(t.StateOf("a"), "DeActive");
  t.On("b", "Protected").code = 5001;
  t.On("b", "Protected").takes = Milliseconds(50);
  EXPECT_EQ(t.Set("Protected").outcome, SwitchOutcome::kUndone);
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
  EXPECT_EQ(t.StateOf("a"), "DeActive");
}

TEST_F(FoundBySimulation, ACheckThatHangsAfterItsSwitchWasSupersededIsRecorded) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "a").critical = true;
  Harness t(config);
  t.On("a", "SelfCheck").code = 5001;
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  t.On("a", "SelfCheck") = {};
  t.On("a", "SelfCheck").hangs = true;
  t.RequestSwitch("SelfCheck");
  t.RunFor(Milliseconds(5));
  t.RequestSwitch("Error");
  t.Rest();
  ASSERT_TRUE(t.RecordOf("a").fault);
  EXPECT_THAT(t.RecordOf("a").fault, Is(texts::FoundBusy("SelfCheck", Milliseconds(100))));
}

// Found by the fault-injection suite.
TEST_F(FoundBySimulation, AnActuatorWithAnOverdueCheckInTheRunPhaseIsWellWhenThatHasPassed) {
  Harness& t = In("Active");
  t.On("b", "SelfCheck").takes = Milliseconds(300);  // of 100
  EXPECT_EQ(t.Set("SelfCheck").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(FoundBySimulation, AControllerThatListensReceivesTheReleaseOfAStop) {
  const EmergencyStop stop{7, "a panel", ""};
  StoredStops received;
  AddReceived(received, stop);
  EXPECT_EQ(received.engaged.size(), 1U);
  AddReceivedRelease(received, 7);
  EXPECT_TRUE(received.engaged.empty());
  AddReceived(received, stop);  // latched, and late
  EXPECT_TRUE(received.engaged.empty());
  EXPECT_TRUE(received.awaits_request);
}

TEST_F(FoundBySimulation, AControllerThatLeadsIgnoresReleasesOfOtherParticipants) {
  Harness& t = In("Active");
  t.StopAll(7);
  t.Rest();
  t.Feed(event::EmergencyStopSeen{{7, "", ""}, false});
  EXPECT_TRUE(t.machine().emergency.stop);
}

// b and another actuator are one process, which is never ended.
TEST_F(FoundBySimulation, AnActuatorTornDownAloneInASharedProcessUndoesNoSwitchUp) {
  Harness& t = In("Protected", MachineOf(3));
  t.shared = {"b"};
  EXPECT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kTornDownAlone));
  const SwitchResult up = t.Set("Active");
  EXPECT_EQ(up.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(up.reason, HasSubstr("b: " + texts::TornDownAlone().message));
  EXPECT_EQ(t.StateOf("a"), "Active");
  EXPECT_EQ(t.Set("SelfCheck").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(t.Set("Active").degraded, ElementsAre("b"));
  EXPECT_TRUE(t.Set("TearDown").done()) << "it is where the machine goes";
}

TEST_F(FoundBySimulation, AnActuatorBoundToATornDownActuatorInASharedProcessIsSuspended) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "a").binds_to = {"b"};
  Harness& t = In("Active", config);
  t.shared = {"b"};
  t.Set("TearDown", "b");
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "DeActive");
}

TEST_F(FoundBySimulation,
       ACriticalActuatorThatIsTornDownInASharedProcessKeepsTheMachineFromGoingUp) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").critical = true;
  Harness& t = In("Protected", config);
  t.shared = {"b"};
  t.Set("TearDown", "b");
  t.ClearLog();
  const SwitchResult up = t.Set("Active");
  EXPECT_EQ(up.outcome, SwitchOutcome::kRefused);
  EXPECT_THAT(up.reason, HasSubstr("critical b " + texts::TornDownAlone().message));
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST_F(FoundBySimulation, AnActuatorThatWasInTheTargetAndIsRestartedMeanwhileIsNotReportedAsDone) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "LowPower").takes = std::chrono::seconds(2);  // of 100 ms
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  const RequestId second = t.RequestSwitch("LowPower");  // for b; a is there
  ASSERT_TRUE(t.machine().current);
  t.Restart("a");
  t.RunUntil([&] { return t.answers.contains(second); });
  ASSERT_EQ(t.StateOf("a"), "SetUp");
  const ActuatorResult& result = Of(t.answers.at(second), "a");
  EXPECT_EQ(result.outcome, ActuatorOutcome::kLost);
  EXPECT_THAT(result.message, HasSubstr("has switched to SetUp since, and is being driven back"));
}

TEST_F(FoundBySimulation,
       AnActuatorThatReportsTearDownWithoutACommandIsListedUntilItReportsAnother) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "c").critical = true;
  Harness t(config);
  t.On("c", "SelfCheck").code = 5001;
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  ActuatorReport report = t.CoreOf("a").report;
  const State truth = report.state;
  const auto publish = [&](const State& state) {
    report.state = state;
    report.stamp = t.now();
    t.Feed(event::StatusSeen{0, report});
    t.RunFor(Milliseconds(1));
  };
  publish("TearDown");
  ASSERT_TRUE(t.RecordOf("a").fault);
  EXPECT_THAT(t.RecordOf("a").fault, Is(EventName::kTornDownAlone));
  t.On("c", "SelfCheck") = {};
  const SwitchResult check = t.Set("SelfCheck");
  EXPECT_EQ(check.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(check.degraded, ElementsAre("a"));
  publish(truth);
  EXPECT_FALSE(t.RecordOf("a").fault);
  EXPECT_TRUE(t.Set("SelfCheck").done());
}

// b never publishes its status, so TearDown does not reach it: it is ended by a signal, later.
TEST_F(FoundBySimulation, ATearDownIsNotDoneWhenATakeoverComesBeforeAProcessHasEnded) {
  Harness t(Ours(2));
  t.On("b", "SetUp").hangs = true;
  t.On("b", "TERM").hangs = true;
  t.Begin();
  t.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(t.machine().state, "Active");
  const RequestId request = t.RequestSwitch("TearDown");
  t.RunUntil([&] { return !t.machine().current && t.RecordOf("a").process.pid == 0; });
  ASSERT_EQ(t.machine().phase, Phase::kStopping) << "a is torn down, b does not end";
  const std::int32_t pid = t.RecordOf("b").process.pid;
  t.ReceiveRivalHeartbeat(99);
  ASSERT_TRUE(t.answers.contains(request));
  const SwitchResult& result = t.answers.at(request);
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
  EXPECT_THAT(result.reason,
              HasSubstr(texts::ProcessLeftBehind(pid, "process 1 elsewhere").message));
}

TEST_F(FoundBySimulation, AnActuatorThatReportedAFalseTearDownIsStillKnownToHang) {
  Harness& t = In("Active");
  t.Find("b", Health::kHung);
  const auto say = [&](const State& state) {
    ActuatorReport report = t.CoreOf("b").report;
    report.stamp = t.now();
    report.state = state;
    t.Feed(event::StatusSeen{*t.config().IndexOf("b"), report});
    t.RunFor(Milliseconds(1));
  };
  say("TearDown");
  EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kTornDownAlone));
  say("Active");
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kActuatorHung));
}

// A late one runs its first check while the others are switched: it is neither listed nor at fault.
TEST_F(FoundBySimulation, ALateActuatorInItsCheckIsNoFaultOfASwitch) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").stage = 2;
  Harness t(config);
  t.On("b", "SelfCheck").takes = Milliseconds(90);
  t.Begin();
  ASSERT_TRUE(t.RunUntil(
      [&] { return std::find(t.log().begin(), t.log().end(), "b:SelfCheck") != t.log().end(); }));
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDone);
  EXPECT_FALSE(t.RecordOf("b").fault);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(FoundBySimulation, AnActuatorWhoseCheckWasSupersededHasAReasonWhyItStays) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "b").command.clear();  // started by hand, after the start has failed
  Harness t(config);
  t.On("a", "SelfCheck").code = 5001;
  t.Begin();
  t.Crash("b");
  t.Rest();
  t.StartActuator("b");
  t.Rest();
  ASSERT_EQ(t.StateOf("b"), "SetUp");
  t.On("a", "SelfCheck").code = kCodeOk;
  t.Mute("b", true, false);
  t.RequestSwitch("SelfCheck");
  t.RunFor(Milliseconds(5));
  t.Set("Error");
  t.Mute("b", false, false);
  t.Rest();
  ASSERT_EQ(t.StateOf("b"), "SetUp");
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kSelfCheckMissing));
}

// Found by a random walk, whose links lost for good what the transport repeats.
TEST_F(FoundBySimulation, AnActuatorWhoseReportOfTheReleaseWasLateCanBeDrivenUpOnceItHasArrived) {
  Harness& t = In("Active", Ours(2));
  t.StopAll(7);
  t.Crash("b");
  t.Rest();
  ASSERT_EQ(t.StateOf("b"), "SelfCheck") << "it waits for the release";
  t.Mute("b", false, true);
  t.Release();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "SelfCheck") << "the command could overtake the release";
  t.Mute("b", false, false);
  t.RepeatStatus("b");
  t.Rest();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

}  // namespace musher::testing::found_by_simulation_test
