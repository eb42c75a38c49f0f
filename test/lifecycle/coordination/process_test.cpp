// Which process belongs to an actuator, which may be signalled, and the effect of its exit.

#include "musher/base/code.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::process_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Processes : public OneController {
 protected:
  Processes() {
    for (ActuatorConfig& actuator : config_.actuators) {
      actuator.command = {"run", actuator.name};
      actuator.restart.policy = RestartPolicy::kOnFailure;
    }
  }
  // With the processes started by the controller, 700 and 701.
  void StartUpOurs() {
    Begin();
    for (ActuatorIndex i = 0; i < 2; ++i) {
      Do(event::ProcessStarted{i, static_cast<std::int32_t>(700 + i.value())});
    }
    for (ActuatorIndex i = 0; i < 2; ++i) Come(i);
    ObeyAll();
    Forget();
  }
};

TEST_F(Processes, AreRecordedWithTheirStartAsTheCause) {
  Begin();
  Do(event::ProcessStarted{0, 700});
  const action::Record record = RecordWith(texts::ProcessStarted("a", 700));
  EXPECT_EQ(record.code, kCodeOk);
  EXPECT_EQ(record.cause, RecordId(1)) << "the controller's beginning";
}

// As on a disk that loads the program slowly.
TEST_F(Processes, ThatFailToExecuteTheirProgramLateAreLost) {
  Begin();
  Do(event::ProcessStarted{0, 700});
  Do(event::ProcessNotStarted{0, "can't run a: No such file or directory"});
  EXPECT_EQ(Of(0).process.pid, 0);
  EXPECT_EQ(Of(0).presence, Presence::kAbsent);
  ASSERT_TRUE(Of(0).fault);
  EXPECT_THAT(Of(0).fault, Is(texts::ProcessNotStarted("can't run a: No such file or directory")));
  EXPECT_EQ(Of(0).fault->code, kCodeFailed);
}

// Two actuators share process 700; one of them was torn down before this controller started.
TEST_F(Processes, ThatRunOneOfTheirActuatorsOnlyAreRestartedByAPerson) {
  Begin();
  for (ActuatorIndex i = 0; i < 2; ++i) Do(event::ProcessStarted{i, 700});
  Come(0);
  Pass(Milliseconds(100));
  ASSERT_TRUE(Of(1).fault);
  EXPECT_THAT(Of(1).fault, Is(texts::NotAnnouncedBeside("b", "a", Milliseconds(100), 700)));
}

TEST_F(Processes, OfAnotherHostAreNotSignalledHoweverTheyHang) {
  Begin();
  for (ActuatorIndex i = 0; i < 2; ++i) Do(event::ProcessStarted{i, 0});
  ActuatorReport report = Report(0);
  report.host = "there";
  Say(0, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  EXPECT_THAT(Did<action::TakeBacktrace>(), IsEmpty());
  Pass(std::chrono::seconds(60));
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
}

TEST_F(Processes, WithoutAHostAreNotSignalledEither) {
  StartUpOurs();
  Of(0).process.pid = 0;
  Of(0).report.host = machine_.host = "";
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  EXPECT_THAT(Did<action::TakeBacktrace>(), IsEmpty());
}

TEST_F(Processes, OfTheControllerThatExitWhileAnotherOfThisHostIsPresentAreNotLosses) {
  StartUpOurs();
  Of(0).report.pid = 900;  // 700 was only its launcher
  Do(event::ProcessEnded{0, 700, true, "exit code 0"});
  EXPECT_EQ(Of(0).presence, Presence::kPresent);
}

// Also with the same pid: found by scenarios, where the controller started a second one here.
TEST_F(Processes, OfTheControllerThatExitAreNoLossesWhileOneOfAnotherHostIsPresent) {
  for (const std::int32_t pid : {900, 700}) {
    StartUpOurs();
    Of(0).report.pid = pid;
    Of(0).report.host = "there";
    Do(event::ProcessEnded{0, 700, false, "exit code 1"});
    EXPECT_EQ(Of(0).presence, Presence::kPresent) << pid;
    Pass(Milliseconds(200));
    EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
  }
}

TEST_F(Processes, ThatExitBeforeTheirFirstStatusAreLossesAlsoAfterOneOfAnotherHost) {
  StartUpOurs();
  Of(0).report.host = "there";
  Of(0).report.pid = 900;
  Of(0).presence = Presence::kLost;
  Of(0).process.pid = 0;
  Of(0).restart.at = machine_.actuators[0].set_up_by.value_or(Time{});
  Pass(Milliseconds(1));
  Do(event::ProcessStarted{0, 800});
  ASSERT_THAT(Did<action::StartProcess>(), SizeIs(1));
  Do(event::ProcessEnded{0, 800, false, "exit code 1"});
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  Pass(Milliseconds(200));
  EXPECT_THAT(Did<action::StartProcess>(), SizeIs(2));
}

TEST_F(Processes, OfTheControllerThatExitAreLossesIfTheOtherIsUnknown) {
  StartUpOurs();
  Of(0).report.pid = 900;
  Of(0).report.host = "";
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  EXPECT_EQ(Of(0).health, Health::kCrashed);
  StartUpOurs();
  Of(0).report.pid = 0;
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  EXPECT_EQ(Of(0).presence, Presence::kLost);
}

TEST_F(Processes, ThatExitBeforeTheirFirstStatusAreRestarted) {
  StartUpOurs();
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  Pass(Milliseconds(100));
  Do(event::ProcessStarted{0, 800});
  ASSERT_THAT(Did<action::StartProcess>(), SizeIs(1));
  Do(event::ProcessEnded{0, 800, false, "exit code 1"});
  Pass(Milliseconds(200));
  EXPECT_THAT(Did<action::StartProcess>(), SizeIs(2));
}

TEST_F(Processes, OfAControllerWithoutAHostNameAreItsOwn) {
  StartUpOurs();
  machine_.host = Of(0).report.host = "";
  Of(0).report.pid = 900;
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  EXPECT_EQ(Of(0).presence, Presence::kLost);
}

TEST_F(Processes, ThatSigkillDoesNotEndAreAssumedToHaveExitedWithTheCodeOfATimeout) {
  StartUpOurs();
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  Pass(std::chrono::seconds(7));
  EXPECT_EQ(RecordWith(EventName::kProcessExitAssumed).code, kCodeTimeout);
}

TEST_F(Processes, ThatHungStayCalledSoWhenTheyEnd) {
  StartUpOurs();
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  Do(event::ProcessEnded{0, 700, false, "killed by SIGKILL"});
  EXPECT_EQ(Of(0).health, Health::kHung);
}

TEST_F(Processes, WhoseActuatorEndedHaveTwoSecondsToExit) {
  StartUpOurs();
  Do(event::Vanished{0, kFirst, true, "its process 700 ended"});
  EXPECT_EQ(Of(0).process.termination.value().kill_at, now_ + std::chrono::seconds(2));
  Pass(std::chrono::seconds(2));
  ASSERT_THAT(Did<action::SignalProcess>(), SizeIs(1));
  EXPECT_TRUE(Did<action::SignalProcess>()[0].kill);
}

TEST_F(Processes, TheirBacktraceIsARecordOfTheProcess) {
  StartUpOurs();
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  Do(event::BacktraceTaken{0, 700, "main()"});
  const action::Record record = RecordWith(texts::BacktraceTaken("a"));
  EXPECT_EQ(record.kind, "process");
  EXPECT_EQ(record.actuator, ActuatorIndex(0));
  EXPECT_EQ(record.data, "main()");
  EXPECT_EQ(RecordWith(EventName::kBacktraceStarted).code, kCodeTimeout);
}

TEST_F(Processes, VerdictsOfAnotherProcessOrAnExitedProcessChangeNothing) {
  StartUpOurs();
  Do(event::HealthChanged{0, kFirst - 1, Health::kHung, true, "it is silent"});
  EXPECT_EQ(Of(0).health, Health::kWell);
  Of(0).process.dead = kFirst;
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  EXPECT_EQ(Of(0).health, Health::kWell);
}

TEST_F(Processes, ThatAreStarvedAreRecordedWithTheCodeOfATimeout) {
  StartUpOurs();
  Do(event::HealthChanged{0, kFirst, Health::kStarved, true, "it waits"});
  EXPECT_EQ(RecordWith(texts::ActuatorStarved("a", "it waits")).code, kCodeTimeout);
}

TEST_F(Processes, OfACriticalActuatorWithoutConnectionTakeTheMachineDownThoughItMayBeRestarted) {
  config_.actuators[0].critical = true;
  config_.actuators[0].on_lost = "LowPower";
  StartUpOurs();
  Of(0).process.pid = 0;
  Of(0).report.host = "there";
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  ASSERT_TRUE(machine_.current);
  EXPECT_EQ(machine_.current->target, "LowPower");
  EXPECT_EQ(RecordWith(texts::FallbackStarted("LowPower")).code, kCodeOk);
}

TEST_F(Processes, OfTheControllerWithoutConnectionAreAwaitedBeforeTheFallback) {
  config_.actuators[0].critical = true;
  config_.actuators[0].on_lost = "LowPower";
  StartUpOurs();
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  Pass(Milliseconds(1900));
  EXPECT_FALSE(machine_.current) << "whether it has ended or hangs will be found out";
}

// The services of a ROS 2 node are gone, and its process lives: the machine waited for ever.
TEST_F(Processes, OfTheControllerOfWhichNothingIsFoundOutTakeTheMachineToTheirOnLost) {
  config_.actuators[0].critical = true;
  config_.actuators[0].on_lost = "LowPower";
  StartUpOurs();
  Do(event::Vanished{0, kFirst, false, "its services are lost"});
  Pass(Milliseconds(2100));
  ASSERT_TRUE(machine_.current);
  EXPECT_EQ(machine_.current->target, kLowPower);
}

// A person debugs it, or the computer is busy.
TEST_F(Processes, OfTheControllerThatAreStarvedTakeTheMachineNowhere) {
  config_.actuators[0].critical = true;
  config_.actuators[0].on_lost = "LowPower";
  StartUpOurs();
  Do(event::Vanished{0, kFirst, false, "its lease is over"});
  Do(event::HealthChanged{0, kFirst, Health::kStarved, true, "a debugger holds its process"});
  Pass(std::chrono::seconds(10));
  EXPECT_FALSE(machine_.current);
  EXPECT_EQ(machine_.state, kActive);
}

TEST_F(Processes, ARestartOfAnUnknownActuatorIsRefusedWithItsNameShortened) {
  StartUpOurs();
  Do(event::RestartRequested{1, std::string(100, 'x')});
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerCall>()[0].result.error().code, kCodeParametersInvalid);
  EXPECT_THAT(Did<action::AnswerCall>()[0].result.error().message,
              HasSubstr("'" + std::string(64, 'x') + "'"));
}

TEST_F(Processes, ThatAreBeingStartedAtATakeoverAreNotReportedAsTornDown) {
  StartUpOurs();
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  Pass(Milliseconds(100));
  ASSERT_EQ(Of(0).process.launch, Launch::kUnderWay);
  Do(event::SetStateRequested{1, "TearDown", {}});
  Obey(1);
  Do(event::ProcessEnded{1, 701, true, "exit code 0"});
  EXPECT_THAT(Did<action::AnswerSetState>(), IsEmpty());
  Do(event::RivalSeen{99, "process 1", true});
  ASSERT_THAT(Did<action::AnswerSetState>(), SizeIs(1));
  const SwitchResult result = Did<action::AnswerSetState>()[0].result;
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ::testing::ElementsAre("a"));
  EXPECT_THAT(result.reason, HasSubstr(texts::ProcessLeftBehind(0, "process 1").message));
}

TEST_F(Processes, ThatCannotBeStartedAreNoLossOfTheOneThatAnotherPartyHasStarted) {
  Begin();
  Say(0, Report(0));  // it has not answered yet
  Do(event::ProcessNotStarted{0, "can't run a: No such file or directory"});
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
  EXPECT_FALSE(Of(0).fault);
}

TEST_F(Processes, ThatDoNotAnnounceTheirActuatorAfterARestartAreReportedSo) {
  StartUpOurs();
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  Pass(Milliseconds(100));
  Do(event::ProcessStarted{0, 800});
  Pass(Milliseconds(100));
  ASSERT_TRUE(Of(0).fault);
  EXPECT_THAT(Of(0).fault,
              Is(texts::NotAnnounced("a", config_.actuators[0].command, Milliseconds(100), 800,
                                     StartProgress::kUnknown)));
}

// One sentence said of a module that loads for long and of a foreign program that it is one of
// both.
TEST_F(Processes, ThatDoNotAnnounceTheirActuatorAreSlowOrForeignAsTheKernelReports) {
  for (const StartProgress progress :
       {StartProgress::kNamed, StartProgress::kBusy, StartProgress::kIdle}) {
    machine_ = MakeMachine(config_);
    StartUpOurs();
    Do(event::ProcessEnded{0, 700, false, "exit code 1"});
    Pass(Milliseconds(100));
    Do(event::ProcessStarted{0, 800});
    Do(event::StartExamined{0, 800, progress});
    ASSERT_TRUE(Of(0).set_up_by) << "it has time left";
    now_ = *Of(0).set_up_by;
    Do(event::StartExamined{0, 800, progress});
    EXPECT_THAT(Of(0).fault, Is(texts::NotAnnounced("a", config_.actuators[0].command,
                                                    Milliseconds(100), 800, progress)));
  }
}

// In a busy controller another event comes before the end of their time is noticed.
TEST_F(Processes, ThatAreOverdueAreGivenUpOnceTheKernelWasAskedAndNotByAnotherEvent) {
  StartUpOurs();
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  Pass(Milliseconds(100));
  Do(event::ProcessStarted{0, 800});
  ASSERT_TRUE(Of(0).set_up_by);
  now_ = *Of(0).set_up_by + Milliseconds(1);
  Do(event::SetUpAwaited{1});
  ASSERT_TRUE(Of(0).set_up_by);
  EXPECT_EQ(Next(), Of(0).set_up_by) << "the time that has passed is the next event";
  Do(event::StartExamined{0, 800, StartProgress::kBusy});
  EXPECT_THAT(Of(0).fault, Is(texts::NotAnnounced("a", config_.actuators[0].command,
                                                  Milliseconds(100), 800, StartProgress::kBusy)));
}

// The one before ran on another host and has exited there.
TEST_F(Processes, ThatAreAboutToBeStartedHereMayBeRestarted) {
  StartUpOurs();
  Of(0).process.pid = 0;
  Of(0).report.host = "there";
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  Pass(Milliseconds(100));
  Do(event::RestartRequested{1, "a"});
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty()) << "it is not refused";
}

// A start may take a while: the shell may have to listen for another controller first.
TEST_F(Processes, ThatAreBeingStartedAreNotStartedOnceMoreByARestart) {
  StartUpOurs();
  Do(event::ProcessEnded{0, 700, false, "signal 11"});
  Pass(Milliseconds(100));
  ASSERT_THAT(Did<action::StartProcess>(), SizeIs(1));
  Do(event::RestartRequested{1, "a"});
  Pass(Milliseconds(20));
  EXPECT_THAT(Did<action::StartProcess>(), SizeIs(1));
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
  Do(event::ProcessStarted{0, 800});
  EXPECT_EQ(Of(0).process.pid, 800);
}

// The wait took longer than the time of SetUp; the request gets all of that again.
TEST_F(Processes, ThatAreStartedLateAnswerARestartWhenTheyHaveCome) {
  StartUpOurs();
  Do(event::ProcessEnded{0, 700, false, "signal 11"});
  Pass(Milliseconds(2000));
  Do(event::RestartRequested{1, "a"});
  Pass(Milliseconds(20));
  EXPECT_THAT(Did<action::StartProcess>(), SizeIs(1));
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
}

TEST_F(Processes, AreSearchedForBeforeTheMachineIsStopped) {
  StartUpOurs();
  Do(event::SetStateRequested{1, "TearDown", {}});
  ObeyAll();
  Do(event::ProcessEnded{0, 700, true, "exit code 0"});
  Step(config_, machine_, event::ProcessEnded{1, 701, true, "exit code 0"}, now_);
  Step(config_, machine_, event::TimePassed{}, now_);
  EXPECT_EQ(machine_.phase, Phase::kStopping) << "the search has not ended";
  Do(event::ProcessesFound{{0, 0}});
  EXPECT_EQ(machine_.phase, Phase::kStopped);
}

using ForeignProcesses = OneController;

TEST_F(ForeignProcesses, ThatHangAndAreSilentAreLostThoughTheyCannotBeRestarted) {
  StartUp();
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  Do(event::HealthChanged{1, kFirst + 1, Health::kHung, false, "its work is stuck"});
  EXPECT_EQ(Of(1).presence, Presence::kPresent);
  EXPECT_EQ(Of(1).fault->code, kCodeTimeout);
}

// Its heartbeats end with its shell, and its process runs on: that is no loss.
TEST_F(ForeignProcesses, ThatWereTornDownAloneAreNoneThatHang) {
  config_.actuators[0].critical = true;
  config_.actuators[0].on_lost = kProtected;
  StartUp();
  Do(event::SetStateRequested{1, kTearDown, "a"});
  Obey(0);
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  EXPECT_FALSE(machine_.current);
  EXPECT_EQ(machine_.state, kActive);
}

// The process of what had been torn down alone got SIGTERM before the other one had its TearDown.
TEST_F(ForeignProcesses, OfAnActuatorTornDownAloneAreEndedAfterTheOtherActuatorInThem) {
  config_.actuators[0].command = {"run", "a"};
  StartUp();
  Of(0).process.pid = Of(1).report.pid = 700;
  Do(event::SetStateRequested{1, kTearDown, "a"});
  Obey(0);
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  Forget();
  Do(event::SetStateRequested{2, kTearDown, {}});
  ASSERT_EQ(Of(1).command.value().target, kTearDown);
  EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
  Obey(1);
  Pass(std::chrono::seconds(10));
  EXPECT_THAT(Did<action::SignalProcess>(),
              ::testing::Contains(action::SignalProcess{0, 700, false}));
}

TEST_F(ForeignProcesses, ThatHangAreNotDrivenAfterTheMachine) {
  StartUp();
  Do(event::HealthChanged{0, kFirst, Health::kHung, false, "its work is stuck"});
  Of(0).report.state = State(kLowPower);
  Of(0).due = true;
  Do(event::TimePassed{});
  EXPECT_FALSE(Of(0).command);
  Do(event::HealthChanged{0, kFirst, Health::kWell, false, "its work goes on"});
  EXPECT_EQ(Of(0).command.value().target, kActive);
}

TEST_F(ForeignProcesses, ThatAreHeldAreNoLongerWhenTheyAreLost) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", "a"});
  Obey(0);
  ASSERT_TRUE(Of(0).held);
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  EXPECT_FALSE(Of(0).held);
}

TEST_F(ForeignProcesses, ThatWereTornDownAloneAreDegradedByThatAndNotByTheirEnd) {
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", "a"});
  Obey(0);
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  ASSERT_TRUE(Of(0).fault);
  EXPECT_EQ(Of(0).fault->code, kCodeStateInvalid);
}

TEST_F(ForeignProcesses, ARivalOfALowerEpochHasNoPrecedence) {
  StartUp();
  machine_.epoch = 7;
  Do(event::RivalSeen{6, "process 1", true});
  EXPECT_THAT(Did<action::Fenced>(), IsEmpty());
}

TEST_F(ForeignProcesses, AnEmergencyStopWithoutAnIdIsOne) {
  StartUp();
  Do(event::EmergencyStopSeen{{0, "operator", ""}});
  EXPECT_TRUE(machine_.emergency.stop);
  EXPECT_EQ(RecordWith(texts::EmergencyStopEngaged("operator", "")).code, kCodeProtectedError);
}

TEST_F(ForeignProcesses, ThatExitWithCode0DuringTheirTearDownHaveEndedIt) {
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", "a"});
  ASSERT_TRUE(Of(0).command);
  event::Vanished vanished{0, kFirst, true, "its process ended: exit code 0"};
  vanished.clean = true;
  Do(vanished);
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_EQ(answers[0].result.outcome, SwitchOutcome::kDone);
  EXPECT_EQ(Of(0).state(), "TearDown");
}

// A SIGKILL counted for the end of the TearDown.
TEST_F(ForeignProcesses, WhoseExitCodeIsUnknownHaveNotEndedTheTearDownThatRan) {
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", "a"});
  ASSERT_TRUE(Of(0).command);
  Do(event::Vanished{0, kFirst, true, "its process ended"});
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_NE(answers[0].result.outcome, SwitchOutcome::kDone);
}

// A SIGKILL counted for the end of the TearDown.
TEST_F(Processes, FoundRunningOfUnknownExitCodeHaveNotEndedTheTearDownThatRan) {
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {true, true}, "here"};
  begin.processes = {700, 701};
  Do(begin);
  for (ActuatorIndex i = 0; i < 2; ++i) Come(i, "Active");
  Forget();
  Do(event::SetStateRequested{1, "TearDown", "a"});
  ASSERT_TRUE(Of(0).command);
  Do(event::ProcessEnded{0, 700, false, "exit code unknown"});
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_NE(answers[0].result.outcome, SwitchOutcome::kDone);
}

TEST_F(Processes, ThatReplaceOneFoundRunningAreNotTornDownByAFailedExit) {
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {true, true}, "here"};
  begin.processes = {700, 701};
  Do(begin);
  for (ActuatorIndex i = 0; i < 2; ++i) Come(i, "Active");
  Do(event::ProcessEnded{0, 700, false, "ended"});
  Pass(std::chrono::seconds(2));
  Do(event::ProcessStarted{0, 700});  // the kernel reuses the pid
  ActuatorReport report = Report(0);
  report.incarnation = 80;
  Say(0, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
  ObeyAll();
  ASSERT_EQ(Of(0).state(), kActive);
  Forget();
  Do(event::SetStateRequested{1, "TearDown", "a"});
  Do(event::ProcessEnded{0, 700, false, "killed by SIGSEGV"});
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_NE(answers[0].result.outcome, SwitchOutcome::kDone);
}

// The late status dropped the restart: it was taken for that of a process that another party had
// started. Of a process of this host that has exited the shell proves no pid: it is 0.
TEST_F(Processes, ThatExitBeforeTheirStatusArrivesAreRestarted) {
  for (const std::int32_t pid : {700, 0}) {
    machine_ = MakeMachine(config_);
    event::Begin begin{false, 0, {true, true}, "here"};
    begin.processes = {700, 701};
    Do(begin);
    Do(event::ProcessEnded{0, 700, false, "exit code unknown"});
    ASSERT_TRUE(Of(0).restart.at);
    Forget();
    ActuatorReport late = Report(0, kActive);
    late.pid = pid;
    late.emergency_stop = 5;
    Say(0, late);
    EXPECT_EQ(Of(0).presence, Presence::kAbsent) << pid;
    EXPECT_TRUE(machine_.emergency.stop) << "what it has latched counts";
    Pass(Milliseconds(150));
    EXPECT_THAT(Did<action::StartProcess>(), SizeIs(1)) << pid;
  }
}

TEST_F(Processes, ThatAnotherPartyStartsBeforeTheirRestartAreNotStartedTwice) {
  for (const std::string& host : {std::string("here"), std::string("there")}) {
    StartUpOurs();
    Do(event::ProcessEnded{0, 700, false, "exit code 1"});
    ASSERT_TRUE(Of(0).restart.at);
    Pass(Milliseconds(100));
    Do(event::ProcessStarted{0, 700});  // the kernel reuses the pid
    Do(event::ProcessEnded{0, 700, false, "exit code 1"});
    ASSERT_TRUE(Of(0).restart.at);
    ActuatorReport report = Report(0);
    report.host = host;
    report.pid = host == "here" ? 800 : 700;
    report.incarnation = 80;
    Say(0, report);
    EXPECT_FALSE(Of(0).restart.at) << host;
    EXPECT_EQ(Of(0).presence, Presence::kStarting) << host;
  }
}

// With units of its own host a start may fail seconds later. It was repeated: both ran.
TEST_F(Processes, WhoseStartFailsBesideAProcessThatAnotherControllerHasAreNotStartedAgain) {
  config_.actuators[0].command = {"run", "a"};
  config_.actuators[0].restart.policy = RestartPolicy::kOnFailure;
  Begin();
  Forget();
  ActuatorReport there = Report(0, kActive);
  there.host = "there";
  Say(0, there);
  machine_.actuators[0].control.again.reset();  // it obeys another controller
  ASSERT_EQ(Of(0).presence, Presence::kStarting);
  Do(event::ProcessNotStarted{0, "systemd of this host: it does not answer"});
  Pass(std::chrono::minutes(1));
  EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
  EXPECT_EQ(Of(0).presence, Presence::kLost);
}

TEST_F(Processes, ThatVanishInTheirSetUpAreGivenUpAfterTheirTerminationAndKill) {
  Begin();
  Do(event::ProcessStarted{0, 700});
  Say(0, Report(0));
  Do(event::Vanished{0, kFirst, true, "its writer was lost"});
  EXPECT_EQ(Of(0).process.termination.value().kill_at, now_ + Milliseconds(2000));
  EXPECT_EQ(Of(0).set_up_by, now_ + Milliseconds(4000));
}

}  // namespace musher::testing::process_test
