// The process of an actuator that the systemd of another host runs for the controller. Its pid is
// one of that host: the decision never takes it for a process of the controller's own host.

#include <algorithm>
#include <optional>

#include "musher/lifecycle/refusal.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::testing::host_process_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int32_t kPid = 41;
constexpr RequestId kRequest = 71;

// Actuator a runs on this host, b on host "vision", whose HostId() is "there".
class HostProcess : public OneController {
 protected:
  HostProcess() {
    for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run", actuator.name};
    config_.transport = TransportProfile::kLan;
    HostConfig& host = config_.hosts.emplace_back();
    host.name = "vision";
    host.address = "10.0.0.2";
    config_.actuators[1].restart.policy = RestartPolicy::kOnFailure;
    config_.actuators[1].host = "vision";
  }
  ActuatorReport ReportOfB(std::int32_t pid = kPid, const std::string& host = "there",
                           const State& state = kSetUp) {
    ActuatorReport report = Report(1, state);
    report.pid = pid;
    report.host = host;
    report.incarnation = kFirst + 1;
    return report;
  }
  void ComeB(std::int32_t pid = kPid, const std::string& host = "there") {
    ActuatorReport report = ReportOfB(pid, host);
    Say(1, report);
    report.epoch = machine_.epoch;
    report.number = Of(1).report.number;
    Do(event::Replied{1, report.number, true, Verdict::kDone, kCodeOk, "", report});
  }
  void ObeyB() {
    const PendingCommand command = Of(1).command.value();
    ActuatorReport report = ReportOfB(Of(1).report.pid, Of(1).report.host, command.target);
    report.epoch = machine_.epoch;
    report.number = report.outcome_number = command.number;
    Do(event::Replied{1, command.number, false, Verdict::kDone, kCodeOk, "", report});
  }
  void ObeyBoth() {
    for (int rounds = 0; rounds < 10; ++rounds) {
      if (Of(0).command) Obey(0);
      if (Of(1).command) ObeyB();
    }
  }
  // Both are Active.
  void StartUpBoth(bool found = false) {
    Begin();
    Do(event::ProcessStarted{0, 700});
    Do(event::ProcessStarted{1, kPid, "there", found});
    Come(0);
    ComeB();
    ObeyBoth();
    ASSERT_EQ(machine_.state, kActive);
    Forget();
  }
};

TEST_F(HostProcess, IsRecordedWithItsHost) {
  Begin();
  Do(event::ProcessStarted{1, kPid, "there"});
  EXPECT_TRUE(IsRecorded(texts::ProcessStartedOn("vision", "b", kPid, false)));
  Do(event::ProcessStarted{1, kPid, "there", true});
  EXPECT_TRUE(IsRecorded(texts::ProcessStartedOn("vision", "b", kPid, true)));
}

// Each power-on ended with "critical b: no route", where the board booted later than this host.
TEST_F(HostProcess, ThatIsCriticalIsAwaitedByTheStartUntilItsHostIsReached) {
  config_.actuators[1].critical = true;
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  Do(event::ProcessNotStarted{1, "no route to 10.0.0.2", true});
  Pass(std::chrono::minutes(2));
  Do(event::ProcessNotStarted{1, "no route to 10.0.0.2", true});
  EXPECT_EQ(machine_.phase, Phase::kStarting);
  EXPECT_FALSE(machine_.current);
  Do(event::ProcessStarted{1, kPid, "there"});
  ComeB();
  ObeyBoth();
  EXPECT_EQ(machine_.state, kActive);
}

// A board that is plugged in hours later would have led the robot to Active by itself.
TEST_F(HostProcess, ThatIsCriticalIsAwaitedByTheStartForThreeMinutes) {
  config_.actuators[1].critical = true;
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  Do(event::ProcessNotStarted{1, "no route to 10.0.0.2", true});
  Pass(std::chrono::minutes(3));
  if (Of(0).command) Obey(0);
  EXPECT_EQ(machine_.phase, Phase::kFailed);
  Do(event::ProcessStarted{1, kPid, "there"});
  ComeB();
  ObeyBoth();
  Pass(std::chrono::minutes(1));
  EXPECT_NE(machine_.state, kActive);
  EXPECT_EQ(machine_.phase, Phase::kFailed);
}

TEST_F(HostProcess, ThatIsCriticalIsNotAwaitedWhereItCannotBeStarted) {
  config_.actuators[1].critical = true;
  config_.actuators[1].restart.policy = RestartPolicy::kNo;
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  Do(event::ProcessNotStarted{1, "there is no such program", false});
  ObeyBoth();
  EXPECT_EQ(machine_.phase, Phase::kFailed);
}

// The machine is led on at once by what is found: its rule for the loss counts.
TEST_F(HostProcess, ThatIsCriticalIsNotAwaitedBesideWhatRunsAlready) {
  config_.actuators[1].critical = true;
  Begin();
  ActuatorReport found = Report(0, kActive);
  Say(0, found);
  found.epoch = machine_.epoch;
  Do(event::Replied{0, found.number, true, Verdict::kDone, kCodeOk, "", found});
  Do(event::ProcessNotStarted{1, "no route to 10.0.0.2", true});
  EXPECT_NE(machine_.phase, Phase::kStarting);
}

TEST_F(HostProcess, ThatExitsIsLostAtOnceAndStartedAgain) {
  StartUpBoth();
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  EXPECT_EQ(Of(1).presence, Presence::kLost);
  EXPECT_EQ(Of(1).process.pid, 0);
  EXPECT_THAT(Of(1).process.host, IsEmpty());
  EXPECT_EQ(Of(1).process.dead, Of(1).report.incarnation);
  Pass(Milliseconds(150));
  ASSERT_THAT(Did<action::StartProcess>(), ::testing::SizeIs(1));
  EXPECT_EQ(Did<action::StartProcess>().front().actuator, ActuatorIndex(1));
}

// The exit of a process of this number on the controller's host is not that of the one in use.
TEST_F(HostProcess, IsNotTheProcessOfAnotherHostWithItsPid) {
  StartUpBoth();
  Of(1).report.host = "a third host";
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
  EXPECT_NE(Of(1).process.dead, Of(1).report.incarnation);
}

TEST_F(HostProcess, IsRestartedOnRequestAndNotRefusedAsOneOfAnotherHost) {
  StartUpBoth();
  Do(event::RestartRequested{kRequest, "b"});
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
  ASSERT_TRUE(Of(1).command);
  EXPECT_EQ(Of(1).command->target, kTearDown);
  ObeyB();
  Do(event::ProcessEnded{1, kPid, true, "exit code 0"});
  Pass(Milliseconds(1));
  EXPECT_THAT(Did<action::StartProcess>(), ::testing::SizeIs(1));
}

TEST_F(HostProcess, IsNeitherEndedNorStartedTwiceWhenItsConnectionIsLost) {
  StartUpBoth();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  EXPECT_EQ(Of(1).presence, Presence::kLost);
  Pass(std::chrono::seconds(60));
  EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  EXPECT_EQ(Of(1).process.pid, kPid);
}

// A frozen process, or a board without power: no exit of it is ever reported, and a robot with legs
// stayed in Active without its eyes.
class CriticalHostProcess : public HostProcess {
 protected:
  CriticalHostProcess() {
    config_.actuators[1].critical = true;
    config_.actuators[1].on_lost = kProtected;
  }
  void BeSilent(Health health) {
    Do(event::HealthChanged{1, kFirst + 1, health, true, "no heartbeat"});
  }
};

TEST_F(CriticalHostProcess, ThatIsSilentTakesTheMachineToItsOnLostAtOnce) {
  StartUpBoth();
  BeSilent(Health::kPartitioned);
  ObeyBoth();
  EXPECT_EQ(machine_.state, kProtected);
}

TEST_F(CriticalHostProcess,
       WhoseConnectionIsLostTakesTheMachineToItsOnLostUnlessItsExitIsReported) {
  StartUpBoth();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Pass(Milliseconds(1900));
  EXPECT_FALSE(machine_.current);
  Pass(Milliseconds(200));
  ObeyBoth();
  EXPECT_EQ(machine_.state, kProtected);
}

TEST_F(CriticalHostProcess, WhoseConnectionIsLostBeforeItsExitIsReportedIsStartedAgain) {
  StartUpBoth();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Pass(Milliseconds(100));
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  Pass(Milliseconds(150));
  EXPECT_THAT(Did<action::StartProcess>(), ElementsAre(action::StartProcess{1}));
  Pass(std::chrono::seconds(4));
  EXPECT_FALSE(machine_.current);
}

// Its heartbeats arrive, and the queries to it do not.
TEST_F(CriticalHostProcess, ThatIsHeardAgainAndDoesNotAnswerTakesTheMachineToItsOnLost) {
  StartUpBoth();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Pass(Milliseconds(1100));
  Do(event::HealthChanged{1, kFirst + 1, Health::kWell, false, "heartbeat received again"});
  Pass(Milliseconds(1900));
  EXPECT_FALSE(machine_.current);
  Pass(Milliseconds(200));
  ObeyBoth();
  EXPECT_EQ(machine_.state, kProtected);
}

TEST_F(CriticalHostProcess, ThatIsHeardAgainAndAnswersTakesTheMachineNowhere) {
  StartUpBoth();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Pass(Milliseconds(1100));
  Do(event::HealthChanged{1, kFirst + 1, Health::kWell, false, "heartbeat received again"});
  ActuatorReport report = ReportOfB(kPid, "there", kActive);
  report.epoch = machine_.epoch;
  report.number = Of(1).report.number;
  Do(event::Replied{1, report.number, true, Verdict::kDone, kCodeOk, "", report});
  Pass(std::chrono::seconds(5));
  EXPECT_FALSE(Of(1).exit_by);
  EXPECT_EQ(machine_.state, kActive);
  EXPECT_FALSE(machine_.current);
}

// The writer of its status ends with its TearDown, before the exit comes by ssh.
TEST_F(CriticalHostProcess, ThatIsRestartedByRequestTakesTheMachineNowhere) {
  StartUpBoth();
  Do(event::RestartRequested{kRequest, "b"});
  ObeyB();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Pass(Milliseconds(500));
  Do(event::ProcessEnded{1, kPid, true, "exit code 0"});
  Pass(Milliseconds(1));
  EXPECT_THAT(Did<action::StartProcess>(), ElementsAre(action::StartProcess{1}));
  EXPECT_FALSE(Of(1).exit_by);
  EXPECT_FALSE(machine_.current);
}

TEST_F(CriticalHostProcess, ThatIsRestartedByRequestTakesTheMachineNowhereAlsoWithoutAPolicy) {
  config_.actuators[1].restart.policy = RestartPolicy::kNo;
  StartUpBoth();
  Do(event::RestartRequested{kRequest, "b"});
  ObeyB();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  EXPECT_FALSE(machine_.current);
  Do(event::ProcessEnded{1, kPid, true, "exit code 0"});
  Pass(Milliseconds(1));
  EXPECT_THAT(Did<action::StartProcess>(), ElementsAre(action::StartProcess{1}));
}

// SIGKILL came in the middle of its TearDown.
TEST_F(CriticalHostProcess, ThatIsSilentHasTheTimeOfATearDownThatBeginsMeanwhile) {
  StartUpBoth();
  BeSilent(Health::kCrashed);
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  Pass(std::chrono::seconds(6));
  EXPECT_THAT(Did<action::SignalProcess>(),
              ::testing::Not(::testing::Contains(action::SignalProcess{1, kPid, true})));
}

TEST_F(CriticalHostProcess, ThatHangsAndCannotBeKilledTakesTheMachineToItsOnLostOnce) {
  config_.actuators[1].critical = false;
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kHung, false, "no checkpoint"});
  Do(event::BacktraceTaken{1, kPid, "none"});
  EXPECT_EQ(machine_.state, kActive) << "the kill may help";
  Pass(Milliseconds(2100));
  ObeyBoth();
  EXPECT_EQ(machine_.state, kProtected);
  Do(event::SetStateRequested{kRequest, kActive, {}});
  ObeyBoth();
  Pass(std::chrono::seconds(10));
  EXPECT_EQ(machine_.state, kActive) << "a person goes on without it";
}

TEST_F(HostProcess, ThatIsSilentAloneForFiveSecondsIsKilledOnItsHost) {
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(Milliseconds(4900));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  Pass(Milliseconds(200));
  EXPECT_THAT(Did<action::SignalProcess>(), ElementsAre(action::SignalProcess{1, kPid, true}));
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  Pass(Milliseconds(150));
  EXPECT_THAT(Did<action::StartProcess>(), ElementsAre(action::StartProcess{1}));
}

// A cut that ends was nothing that its process could help.
TEST_F(HostProcess, ThatIsHeardAgainWithinFiveSecondsIsNotKilled) {
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(Milliseconds(4900));
  Do(event::HealthChanged{1, kFirst + 1, Health::kWell, false, "heartbeat received again"});
  Pass(std::chrono::seconds(10));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
}

TEST_F(HostProcess, ThatWasTheFirstToBeSilentOfItsHostIsNotKilled) {
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(Milliseconds(500));
  Do(event::HealthChanged{1, kFirst + 1, Health::kPartitioned, true, "no heartbeat"});
  Pass(std::chrono::seconds(10));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
}

TEST_F(HostProcess, ThatStaysSilentAfterACutIsKilledAfterTwentySeconds) {
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kPartitioned, true, "no heartbeat"});
  Pass(std::chrono::seconds(60));
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(Milliseconds(19'900));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  Pass(Milliseconds(200));
  EXPECT_THAT(Did<action::SignalProcess>(), ElementsAre(action::SignalProcess{1, kPid, true}));
}

// The first to be silent before a cut of four seconds may be the last to be discovered after it.
TEST_F(HostProcess, ThatWasTheFirstToBeSilentBeforeACutHasTheTimeOfOneAfterACut) {
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(Milliseconds(500));
  Do(event::HealthChanged{1, kFirst + 1, Health::kPartitioned, true, "no heartbeat"});
  Pass(Milliseconds(4000));
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(Milliseconds(19'900));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  Pass(Milliseconds(200));
  EXPECT_THAT(Did<action::SignalProcess>(), ElementsAre(action::SignalProcess{1, kPid, true}));
}

// Its heartbeats end with its shell. Its process runs on for another actuator, or still saves.
TEST_F(HostProcess, ThatIsTornDownAloneIsNotKilledForItsSilence) {
  StartUpBoth();
  Do(event::SetStateRequested{kRequest, kTearDown, "b"});
  ObeyB();
  ASSERT_EQ(Of(1).state(), kTearDown);
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  Pass(std::chrono::seconds(10));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
}

// The first timer after a stop of the controller itself: what was received is not read yet.
TEST_F(HostProcess, IsNotKilledForASilenceInWhichTheControllerWasStopped) {
  StartUpBoth();
  Do(event::HealthChanged{1, kFirst + 1, Health::kCrashed, true, "no heartbeat"});
  now_ += std::chrono::seconds(20);
  Do(event::TimePassed{});
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
}

TEST_F(HostProcess, IsStoredForTheNextControllerAsOneOfAnotherHost) {
  Begin();
  Do(event::ProcessStarted{1, kPid, "there"});
  ComeB();
  const auto saves = Did<action::SaveRemoteActuators>();
  ASSERT_THAT(saves, ::testing::SizeIs(1));
  EXPECT_THAT(saves.back().actuators, ElementsAre(RemoteActuator{"b", "there"}));
}

TEST_F(HostProcess, EndsWithTheMachine) {
  StartUpBoth();
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  ObeyBoth();
  Pass(Milliseconds(1100));
  EXPECT_THAT(Did<action::SignalProcess>(),
              ::testing::Contains(action::SignalProcess{1, kPid, false}));
  Do(event::ProcessEnded{0, 700, true, "exit code 0"});
  Do(event::ProcessEnded{1, kPid, true, "exit code 0"});
  EXPECT_EQ(machine_.phase, Phase::kStopped);
}

TEST_F(HostProcess, OutOfReachIsNamedByTheTearDownWithItsHost) {
  StartUpBoth();
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  Obey(0);
  Do(event::ProcessEnded{0, 700, true, "exit code 0"});
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Forget();
  Pass(config_.shutdown_budget * 95 / 100);
  EXPECT_THAT(Did<action::FindProcesses>(), ::testing::SizeIs(1));
  event::ProcessesFound found{{0, 0}};
  found.hosts = {"", ""};
  found.unreached = {"", "no route to host"};
  Do(found);
  Pass(config_.shutdown_budget);
  ASSERT_EQ(machine_.phase, Phase::kStopped);
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_THAT(answers, ::testing::SizeIs(1));
  EXPECT_EQ(answers.back().result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(answers.back().result.degraded, ElementsAre("b"));
  EXPECT_THAT(answers.back().result.reason,
              HasSubstr(texts::HostUnreached("vision", "no route to host").message));
}

// The machine was reported as torn down while a process of an earlier controller ran there.
TEST_F(HostProcess, WhoseHostHasNotAnsweredTheSearchWithinTheBudgetIsNamedByTheTearDown) {
  Begin();
  Do(event::ProcessNotStarted{0, "none"});
  Do(event::ProcessNotStarted{1, "none"});
  answers_search_ = false;
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  Pass(config_.shutdown_budget);
  ASSERT_EQ(machine_.phase, Phase::kStopped);
  EXPECT_THAT(Did<action::FindProcesses>(), ::testing::SizeIs(1));
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_THAT(answers, ::testing::SizeIs(1));
  EXPECT_EQ(answers.back().result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(answers.back().result.reason, HasSubstr("b: host vision is out of reach"));
}

TEST_F(HostProcess, ThatHasExitedIsNotNamedByTheTearDownWhenTheSearchIsNotAnswered) {
  StartUpBoth();
  answers_search_ = false;
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  ObeyBoth();
  Do(event::ProcessEnded{0, 700, true, "exit code 0"});
  Do(event::ProcessEnded{1, kPid, true, "exit code 0"});
  Pass(config_.shutdown_budget);
  ASSERT_EQ(machine_.phase, Phase::kStopped);
  EXPECT_EQ(Did<action::AnswerSetState>().back().result.outcome, SwitchOutcome::kDone);
}

// With a short budget the queries for the outcome of TearDown end after SIGKILL.
TEST_F(HostProcess, IsSearchedForWithSigkillIfTheSwitchHasNotEndedBefore) {
  config_.shutdown_budget = Milliseconds(800);
  StartUpBoth();
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  Pass(config_.shutdown_budget * 95 / 100);
  ASSERT_TRUE(machine_.current);
  EXPECT_THAT(Did<action::FindProcesses>(), ::testing::SizeIs(1));
}

TEST_F(HostProcess, ThatIsFoundByTheTearDownIsEndedOnItsHost) {
  Begin();
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  Do(event::ProcessNotStarted{1, "none"});
  event::ProcessesFound found{{0, kPid}};
  found.hosts = {"", "there"};
  found.unreached = {"", ""};
  Do(found);
  EXPECT_EQ(Of(1).process.host, "there");
  EXPECT_THAT(Did<action::SignalProcess>(),
              ::testing::Contains(action::SignalProcess{1, kPid, false}));
}

// An early SIGTERM would cancel the callback.
TEST_F(HostProcess, ThatIsFoundDuringItsTearDownIsNotSignalledBeforeTheCallbackEnds) {
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  ComeB();
  ObeyBoth();
  Do(event::SetStateRequested{kRequest, "TearDown", {}});
  ASSERT_TRUE(Of(1).command);
  Do(event::ProcessStarted{1, kPid, "there", true});
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  ObeyBoth();
  Pass(Milliseconds(1100));
  EXPECT_THAT(Did<action::SignalProcess>(),
              ::testing::Contains(action::SignalProcess{1, kPid, false}));
}

TEST_F(HostProcess, ThatIsFoundAgainAfterAFalseExitIsUsedAgain) {
  StartUpBoth();
  Do(event::ProcessEnded{1, kPid, false, "exit code unknown"});
  ASSERT_EQ(Of(1).process.dead, Of(1).report.incarnation);
  Do(event::ProcessStarted{1, kPid, "there", true});
  ComeB();
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
}

TEST_F(HostProcess, ThatIsFoundAgainAfterAFalseExitBeforeItsStatusIsUsed) {
  Begin();
  Do(event::ProcessStarted{1, kPid, "there"});
  Do(event::ProcessEnded{1, kPid, false, "exit code unknown"});
  Do(event::ProcessStarted{1, kPid, "there", true});
  ComeB();
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
}

// The status came by another way than the exit, and later.
TEST_F(HostProcess, ThatExitsBeforeItsStatusArrivesIsStartedAgain) {
  Begin();
  Do(event::ProcessStarted{1, kPid, "there"});
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  ASSERT_TRUE(Of(1).restart.at);
  Forget();
  Say(1, ReportOfB());
  EXPECT_EQ(Of(1).presence, Presence::kLost);
  Pass(Milliseconds(150));
  EXPECT_THAT(Did<action::StartProcess>(), ::testing::Contains(action::StartProcess{1}));
}

TEST_F(HostProcess, ThatIsFoundInsteadOfItsRestartIsUsedAgain) {
  StartUpBoth();
  Do(event::ProcessEnded{1, kPid, false, "exit code unknown"});
  Pass(Milliseconds(150));
  ASSERT_THAT(Did<action::StartProcess>(), ::testing::SizeIs(1));
  Do(event::ProcessStarted{1, kPid, "there", true});
  ComeB();
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
}

TEST_F(HostProcess, OfAnotherPidIsNotTheOneThatHasExited) {
  StartUpBoth();
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  Do(event::ProcessStarted{1, kPid + 1, "there", true});
  EXPECT_EQ(Of(1).process.dead, Of(1).report.incarnation);
}

TEST_F(HostProcess, IsNotTakenToHaveExitedUntilItsHostReportsThat) {
  StartUpBoth();
  Do(event::Vanished{1, kFirst + 1, true, "killed"});
  Pass(std::chrono::seconds(30));
  EXPECT_FALSE(IsRecorded(texts::ProcessExitAssumed(kPid)));
  EXPECT_EQ(Of(1).process.pid, kPid);
  EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
  EXPECT_THAT(Did<action::SignalProcess>(),
              ::testing::Contains(action::SignalProcess{1, kPid, true}));
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  Pass(Milliseconds(150));
  EXPECT_THAT(Did<action::StartProcess>(), ::testing::SizeIs(1));
}

TEST_F(HostProcess, ThatCannotBeStartedIsLostAndNotAbsentWhenAnEarlierOneMayRun) {
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  ComeB();
  ObeyBoth();
  Do(event::Vanished{1, kFirst + 1, false, "connection lost"});
  Do(event::RestartRequested{kRequest, "b"});
  Pass(Milliseconds(1));
  ASSERT_THAT(Did<action::StartProcess>(), ::testing::Contains(action::StartProcess{1}));
  Do(event::ProcessNotStarted{1, "host vision (10.0.0.2): no route to host"});
  EXPECT_EQ(Of(1).presence, Presence::kLost);
}

// A board boots later than the controller: there was no process that could have failed.
TEST_F(HostProcess, ThatWaitsForItsHostIsNotRestartedAndNotGivenUp) {
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  Do(event::ProcessNotStarted{1, "host vision (10.0.0.2): no route to host", true});
  ObeyBoth();
  EXPECT_EQ(machine_.state, kActive);
  Forget();
  Pass(std::chrono::hours(1));
  EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
  EXPECT_EQ(Of(1).restart.count, 0);
  EXPECT_FALSE(Of(1).restart.given_up);
  EXPECT_THAT(Of(1).fault->message, HasSubstr("no route to host"));

  Do(event::ProcessStarted{1, kPid, "there"});
  ComeB();
  ObeyBoth();
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
  EXPECT_EQ(Of(1).state(), kActive);
  EXPECT_FALSE(Of(1).fault);
}

TEST_F(HostProcess, ThatHasWaitedForItsHostAndDoesNotAnnounceItselfIsReported) {
  Begin();
  Do(event::ProcessNotStarted{1, "host vision (10.0.0.2): no route to host", true});
  Pass(std::chrono::minutes(1));
  Do(event::ProcessStarted{1, kPid, "there"});
  Pass(config_.TimeFor(1, kSetUp));
  EXPECT_NE(Of(1).fault->event, EventName::kProcessNotStarted);
}

TEST_F(HostProcess, ThatIsCriticalAndWaitsForItsHostTakesTheMachineDown) {
  config_.actuators[1].critical = true;
  config_.actuators[1].on_lost = kProtected;
  StartUpBoth();
  Do(event::ProcessEnded{1, kPid, false, "exit code unknown"});
  Pass(Milliseconds(150));
  Do(event::ProcessNotStarted{1, "host vision (10.0.0.2): no route to host", true});
  ObeyBoth();
  EXPECT_EQ(machine_.state, kProtected);
}

// A person has gone on without it.
TEST_F(HostProcess, WhoseHostComesAndGoesTakesTheMachineDownOnce) {
  config_.actuators[1].on_lost = kProtected;
  Begin();
  Do(event::ProcessStarted{0, 700});
  Come(0);
  Do(event::ProcessNotStarted{1, "host vision (10.0.0.2): no route to host", true});
  ObeyBoth();
  EXPECT_EQ(machine_.state, kProtected);
  Do(event::SetStateRequested{kRequest, "Active", {}});
  ObeyBoth();
  ASSERT_EQ(machine_.state, kActive);
  Do(event::ProcessNotStarted{1, "host vision (10.0.0.2): connection lost", true});
  ObeyBoth();
  EXPECT_EQ(machine_.state, kActive);
}

// On the controller's host its pid belongs to a process of another kind.
TEST_F(HostProcess, ThatHasExitedIsNotSignalledAnyMore) {
  StartUpBoth();
  Of(1).process.termination = Termination{kPid, std::nullopt, now_ + Milliseconds(2000), false};
  Of(1).report.host = "a third host";
  Do(event::ProcessEnded{1, kPid, false, "killed by SIGKILL"});
  Pass(std::chrono::seconds(10));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
}

// A standby has begun to lead: a was found, and the host of b, which is gone, is still waited for.
class LeadingOn : public HostProcess {
 protected:
  LeadingOn() {
    for (ActuatorConfig& actuator : config_.actuators) {
      std::ranges::fill(actuator.times, Duration(std::chrono::seconds(20)));
    }
  }
  void BeginBeside(const State& state) {
    machine_ = MakeMachine(config_);
    event::Begin begin{false, Epoch(1), PerActuator<bool>(config_.actuators.size()), "here"};
    begin.running[0] = true;
    begin.supervised = begin.restarted = true;
    Do(begin);
    found_in_ = state;
  }
  void ComeA() { Come(0, found_in_); }
  void LoseTheHost() { Do(event::ProcessNotStarted{1, "no route to 10.0.0.2", true}); }
  void Request(const State& state, RequestId request = kRequest, const Requester& by = {}) {
    Do(event::SetStateRequested{request, state, {}, AfterTearDown::kStaysDown, by});
  }
  std::optional<SwitchResult> AnswerTo(RequestId request = kRequest) const {
    for (const auto& answer : Did<action::AnswerSetState>()) {
      if (answer.request == request) return answer.result;
    }
    return std::nullopt;
  }
  State found_in_;
};

// It was refused for 2.5 s.
TEST_F(LeadingOn, CarriesOutARequestOnceTheHostThatIsGoneWasWaitedFor) {
  for (const bool before_a : {true, false}) {
    BeginBeside("Active");
    if (!before_a) ComeA();
    Request("LowPower");
    if (before_a) ComeA();
    Pass(std::chrono::seconds(2));
    EXPECT_FALSE(AnswerTo());
    EXPECT_FALSE(Of(0).command);
    EXPECT_TRUE(IsRecorded(EventName::kSwitchWaiting));
    LoseTheHost();
    ASSERT_TRUE(Of(0).command);
    EXPECT_EQ(Of(0).command->target, kLowPower);
    Obey(0);
    EXPECT_EQ(machine_.state, kLowPower);
    EXPECT_EQ(AnswerTo()->outcome, SwitchOutcome::kDoneDegraded) << AnswerTo()->reason;
    Forget();
  }
}

TEST_F(LeadingOn, CarriesOutARequestBeforeTheFallbackOfWhatIsGone) {
  config_.actuators[1].critical = true;
  config_.actuators[1].on_lost = kProtected;
  BeginBeside("Active");
  ComeA();
  Request("LowPower");
  LoseTheHost();
  Obey(0);
  EXPECT_EQ(AnswerTo()->outcome, SwitchOutcome::kDoneDegraded) << AnswerTo()->reason;
  EXPECT_FALSE(machine_.current) << "nothing rises to Protected";
  EXPECT_EQ(machine_.state, kLowPower);
}

TEST_F(LeadingOn, FallsBackAfterARequestThatDoesNotLowerTheMachine) {
  config_.actuators[1].on_lost = kProtected;
  BeginBeside("Active");
  ComeA();
  Request("Active");
  LoseTheHost();
  ObeyBoth();
  EXPECT_EQ(AnswerTo()->outcome, SwitchOutcome::kDoneDegraded) << AnswerTo()->reason;
  EXPECT_EQ(machine_.state, kProtected);
}

TEST_F(LeadingOn, RefusesARequestThatHasWaitedForTenSeconds) {
  BeginBeside("Active");
  ComeA();
  Request("LowPower");
  Pass(std::chrono::milliseconds(9'900));
  EXPECT_FALSE(AnswerTo());
  Pass(std::chrono::milliseconds(200));
  ASSERT_TRUE(AnswerTo());
  EXPECT_THAT(*AnswerTo(), IsRefused(Refusal::kNotSetUp));
  LoseTheHost();
  EXPECT_FALSE(Of(0).command);
}

TEST_F(LeadingOn, RefusesAnUnknownStateAndASecondRequestAtOnce) {
  BeginBeside("Active");
  ComeA();
  Request("Lowpower");
  EXPECT_THAT(*AnswerTo(), IsRefused(Refusal::kUnknownState));
  Request("LowPower", 72);
  Request("OTA", 73);
  EXPECT_THAT(*AnswerTo(73), IsRefused(Refusal::kSwitchWaiting));
  Request("Error", 74);
  EXPECT_THAT(*AnswerTo(72), IsRefused(Refusal::kSwitchWaiting)) << "Error goes first";
  LoseTheHost();
  ASSERT_TRUE(Of(0).command);
  EXPECT_EQ(Of(0).command->target, kError);
}

TEST_F(LeadingOn, TearsDownAtOnce) {
  BeginBeside("Active");
  ComeA();
  Request("LowPower");
  Request("TearDown", 72);
  ASSERT_TRUE(AnswerTo());
  EXPECT_EQ(AnswerTo()->outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(machine_.phase, Phase::kStopping);
}

// From where the machine is led on is known only then.
TEST_F(LeadingOn, RaisesNothingForAManagerThatHasAskedBefore) {
  BeginBeside("LowPower");
  ComeA();
  Request("Active", kRequest, {"/lifecycle_manager", true});
  LoseTheHost();
  ASSERT_TRUE(AnswerTo());
  EXPECT_THAT(*AnswerTo(), IsRefused(Refusal::kRequestedByAnother));
  EXPECT_EQ(machine_.state, kLowPower);
}

TEST_F(LeadingOn, RaisesNothingByARequestFromBeforeAnEmergencyStop) {
  BeginBeside("LowPower");
  ComeA();
  Request("Active");
  Do(event::EmergencyStopSeen{{7, "alice", "smoke"}});
  ASSERT_TRUE(AnswerTo()) << "it would wait beyond the release";
  EXPECT_FALSE(AnswerTo()->done());
  LoseTheHost();
  EXPECT_FALSE(Of(0).command);
}

// A start from the beginning is not cut short, and a request into it is answered at once.
TEST_F(LeadingOn, KeepsNoRequestWaitingInAStartFromTheBeginning) {
  Begin();
  Request("LowPower");
  ASSERT_TRUE(AnswerTo());
  EXPECT_THAT(*AnswerTo(), IsRefused(Refusal::kNotSetUp));
}

}  // namespace musher::testing::host_process_test
