// How a controller takes control of an actuator, and which of its reports count.

#include "musher/base/code.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::take_control_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

using TakeControl = OneController;

TEST_F(TakeControl, IsRepeatedUntilItIsAnsweredAndRaisesNoEpoch) {
  Begin();
  Say(0, Report(0));
  ASSERT_THAT(Did<action::SendQuery>(), SizeIs(1));
  now_ += Milliseconds(1);
  ActuatorReport report = Report(0);  // it has received the query; its answer is lost
  report.epoch = machine_.epoch;
  Say(0, report);
  Forget();
  Pass(Milliseconds(498));
  EXPECT_THAT(Did<action::SendQuery>(), IsEmpty());
  Pass(Milliseconds(1));
  EXPECT_THAT(Did<action::SendQuery>(), SizeIs(1));
  EXPECT_THAT(Did<action::SaveEpoch>(), IsEmpty());
}

TEST_F(TakeControl, OfAnActuatorThatDeniesOurEpochWaitsForTheHeartbeatOfItsController) {
  Begin();
  ActuatorReport report = Report(0);
  report.epoch = machine_.epoch;
  Say(0, report);
  EXPECT_THAT(Did<action::SendQuery>(), SizeIs(1)) << "perhaps the epoch is from us";
  Do(event::Replied{0, 0, true, Verdict::kRefused, kCodePermissionDenied, "", report});
  EXPECT_EQ(Of(0).set_up_by, now_ + Milliseconds(1700)) << "it is not given up meanwhile";
  Forget();
  Pass(Milliseconds(1199));
  EXPECT_THAT(Did<action::SendQuery>(), IsEmpty());
  Pass(Milliseconds(1));
  EXPECT_THAT(Did<action::SendQuery>(), SizeIs(1));
  EXPECT_EQ(machine_.epoch, report.epoch + 1);
}

// A query for the process before has reached it.
TEST_F(TakeControl, OfANewProcessThatHasOurEpochAlreadyTakesNoTimeAndRaisesNone) {
  StartUp();
  const Epoch epoch = machine_.epoch;
  for (int restart = 1; restart <= 3; ++restart) {
    Do(event::Vanished{0, Of(0).report.incarnation, false, "connection lost"});
    ActuatorReport report = Report(0);
    report.incarnation += 100 * restart;
    report.epoch = epoch;
    Say(0, report);
    Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
    EXPECT_EQ(Of(0).presence, Presence::kPresent);
  }
  EXPECT_EQ(machine_.epoch, epoch);
}

TEST_F(TakeControl, ThatIsDeniedIsRetriedSoonAndIsNotAnAnswer) {
  Begin();
  Say(0, Report(0));
  Do(event::Replied{0, 0, true, Verdict::kRefused, kCodePermissionDenied, "", Report(0)});
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
  EXPECT_EQ(Next(), now_ + Milliseconds(20));
}

TEST_F(TakeControl, ThatIsRefusedForAnotherReasonIsNotRetriedSoonerAndRaisesNoEpoch) {
  Begin();
  Say(0, Report(0));
  const auto again = Of(0).control.again;
  now_ += Milliseconds(1);
  ActuatorReport report = Report(0);
  Do(event::Replied{0, 0, true, Verdict::kRefused, kCodeParametersInvalid, "", report});
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
  EXPECT_EQ(Of(0).control.again, again);
  EXPECT_FALSE(Of(0).control.rival_until);
}

TEST_F(TakeControl, ThatIsAnsweredMakesItPresentAndRecordsItsProcessIfAny) {
  Begin();
  Come(0);
  EXPECT_TRUE(IsRecorded(texts::ActuatorPresent("a", "SetUp", 700)));
  ActuatorReport report = Report(1);
  report.pid = 0;
  Say(1, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{1, 0, true, Verdict::kDone, kCodeOk, "", report});
  EXPECT_TRUE(IsRecorded(texts::ActuatorPresent("b", "SetUp", 0)));
}

TEST_F(TakeControl, IsNotRepeatedWhenADenialArrivesAfterTheAnswer) {
  StartUp();
  ActuatorReport report = Report(0, "Active");
  report.epoch = 0;
  report.stamp -= Milliseconds(1);
  Do(event::Replied{0, 0, true, Verdict::kRefused, kCodePermissionDenied, "", report});
  Pass(std::chrono::seconds(1));
  EXPECT_THAT(Did<action::SendQuery>(), IsEmpty());
}

TEST_F(TakeControl, IsNotAnsweredByTheLateReplyToACommand) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  const CommandNumber number = Of(0).command.value().number;
  const ActuatorReport late = Report(0, "LowPower");
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  now_ += Milliseconds(1);
  Say(0, Report(0, "Active"));
  Do(event::Replied{0, number, false, Verdict::kDone, kCodeOk, "", late});
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
}

TEST_F(TakeControl, OfADetachedActuatorThatIsTornDownMeanwhileDegradesIt) {
  Begin();
  ActuatorReport report = Report(1, "Active");
  report.detached = true;
  report.target = "TearDown";
  Say(1, report);
  report.state = "TearDown";
  report.target = {};
  report.epoch = machine_.epoch;
  Do(event::Replied{1, 0, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_TRUE(Of(1).fault);
  EXPECT_EQ(Of(1).fault->code, kCodeStateInvalid);
  EXPECT_EQ(Of(1).fault->event, EventName::kTornDownAlone);
}

// It arrived after the link had worked again, beside the next command.
TEST_F(TakeControl, OfALostActuatorFencesWhatWasSentToItBefore) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  const CommandNumber sent = Of(0).command.value().number;
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  Forget();
  now_ += Milliseconds(1);
  Say(0, Report(0, "Active"));
  const auto queries = Did<action::SendQuery>();
  ASSERT_THAT(queries, SizeIs(1));
  EXPECT_EQ(queries[0].command.number, sent);
  ActuatorReport report = Report(0, "Active");
  report.epoch = machine_.epoch;
  Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
  EXPECT_EQ(Of(0).presence, Presence::kStarting) << "it answers an earlier query";
  report.number = sent;
  Do(event::Replied{0, sent, true, Verdict::kDone, kCodeOk, "", report});
  EXPECT_EQ(Of(0).presence, Presence::kPresent);
}

using Reports = OneController;

TEST_F(Reports, OfTheSameStampTheLaterCounts) {
  StartUp();
  ActuatorReport report = Report(0, "Active");
  report.outcome_message = "first";
  Say(0, report);
  report.outcome_message = "second";
  Say(0, report);
  EXPECT_EQ(Of(0).report.outcome_message, "second");
  report.stamp -= Duration(1);
  report.outcome_message = "third";
  Say(0, report);
  EXPECT_EQ(Of(0).report.outcome_message, "second");
}

TEST_F(Reports, OnlyACheckThatWasSeenToRunCountsAsPassed) {
  Begin();
  Come(0);
  ActuatorReport report = Report(0, "SelfCheck");
  Say(0, report);
  EXPECT_FALSE(Of(0).checked);
  report = Report(0, "SelfCheck");
  report.target = "LowPower";
  Say(0, report);
  report = Report(0, "LowPower");
  Say(0, report);
  EXPECT_FALSE(Of(0).checked) << "what came free was no check";
}

TEST_F(Reports, AFailedSetUpIsRecordedWithItsCodeAndASetUpThatHasNotBegunIsNotAFailure) {
  Begin();
  Say(0, Report(0, "Uninitialized"));
  EXPECT_FALSE(Of(0).fault);
  ActuatorReport report = Report(1, "Uninitialized");
  report.outcome_code = 5012;
  report.outcome_message = "no microphone";
  Say(1, report);
  ASSERT_TRUE(Of(1).fault);
  EXPECT_EQ(Of(1).fault->code, 5012);
  EXPECT_THAT(Of(1).fault, Is(texts::SetUpFailed(5012, "no microphone")));
}

TEST_F(Reports, OfANewProcessEndTheCommandOfItsPredecessor) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  ASSERT_TRUE(Of(0).command);
  ActuatorReport report = Report(0);
  report.incarnation += 100;
  report.pid += 100;
  report.epoch = 0;
  Say(0, report);
  EXPECT_FALSE(Of(0).command);
  EXPECT_FALSE(Of(0).checked);
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
  EXPECT_TRUE(IsRecorded(EventName::kActuatorReplaced));
}

TEST_F(Reports, OfAnImpostorAreRecordedWithItsHostShortened) {
  StartUp();
  ActuatorReport report = Report(0);
  report.incarnation += 100;
  report.host = std::string(100, 'h');
  Say(0, report);
  EXPECT_TRUE(IsRecorded(texts::DuplicateActuator("a", 700, std::string(64, 'h'), 700)));
}

// The other one is used when this one is lost.
TEST_F(Reports, OfTwoHostsBeforeEitherProcessIsAttachedAreBothRemembered) {
  Begin();
  ActuatorReport elsewhere = Report(0);
  elsewhere.incarnation += 100;
  elsewhere.pid += 100;
  elsewhere.host = "dock";
  Say(0, elsewhere);
  Come(0);
  EXPECT_TRUE(IsRecorded(texts::DuplicateActuator("a", 800, "dock", 700)));
  Do(event::Vanished{0, kFirst, true, "its process 700 ended"});
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
  EXPECT_EQ(Of(0).report.host, "dock");
}

// It degraded the one in use, with a reason that was not its own.
TEST_F(Reports, OfASecondProcessWhoseSetUpHasFailedLeaveTheOneInUseAsItIs) {
  for (const bool announced : {true, false}) {
    StartUp();
    ActuatorReport second = Report(0, config_.default_state);
    second.incarnation += 100;
    second.pid += 100;
    second.host = "dock";
    second.epoch = 0;
    if (announced) Say(0, second);
    second.outcome_code = 5012;
    second.outcome_message = "no microphone";
    Say(0, second);
    EXPECT_FALSE(Of(0).fault) << announced;
    EXPECT_FALSE(Of(0).other) << announced;
    EXPECT_EQ(Of(0).presence, Presence::kPresent) << announced;
    EXPECT_EQ(Of(0).report.host, "here") << announced;
    EXPECT_TRUE(IsRecorded(texts::DuplicateActuator("a", 800, "dock", 700))) << announced;
    EXPECT_FALSE(IsRecorded(EventName::kSetUpFailed)) << announced;
  }
}

TEST_F(Reports, OfASecondProcessWhoseSetUpHasFailedDoNotDegradeTheOneThatIsBeingAttached) {
  Begin();
  Say(0, Report(0));
  ASSERT_TRUE(Of(0).control.again);
  ActuatorReport second = Report(0, config_.default_state);
  second.incarnation += 100;
  second.pid += 100;
  second.host = "dock";
  second.outcome_code = 5012;
  Say(0, second);
  EXPECT_FALSE(Of(0).fault);
  EXPECT_EQ(Of(0).report.incarnation, kFirst);
}

// The process that has failed is the next one of the actuator, and the one before is known to have
// ended.
TEST_F(Reports, OfASuccessorWhoseSetUpHasFailedDegradeTheActuator) {
  StartUp();
  Do(event::Vanished{0, kFirst, true, "its process 700 ended"});
  ActuatorReport successor = Report(0, config_.default_state);
  successor.incarnation += 100;
  successor.outcome_code = 5012;
  successor.outcome_message = "no microphone";
  Say(0, successor);
  EXPECT_THAT(Of(0).fault, Is(texts::SetUpFailed(5012, "no microphone")));
}

// Only one process of a host has the name of the actuator: the one before it has ended, and the
// exit is not known yet. The reason was taken for that of a second process.
TEST_F(Reports, OfASuccessorWhoseSetUpHasFailedBeforeTheExitIsKnownDegradeTheActuator) {
  StartUp();
  ActuatorReport successor = Report(0, config_.default_state);
  successor.incarnation += 100;
  successor.host = Of(0).report.host;
  successor.outcome_code = 5012;
  successor.outcome_message = "no microphone";
  Say(0, successor);
  EXPECT_THAT(Of(0).fault, Is(texts::SetUpFailed(5012, "no microphone")));
}

TEST_F(Reports, OfAProcessThatHasExitedAreIgnored) {
  StartUp();
  const ActuatorReport last = Report(0, "Active");
  Do(event::Vanished{0, last.incarnation, true, "its process ended"});
  Say(0, last);
  EXPECT_EQ(Of(0).presence, Presence::kLost);
}

TEST_F(Reports, AnActuatorLostInItsSetUpIsDegraded) {
  Begin();
  ActuatorReport report = Report(0, "Uninitialized");
  report.target = "SetUp";
  Say(0, report);
  Do(event::Vanished{0, report.incarnation, true, "its process 700 ended"});
  ASSERT_TRUE(Of(0).fault);
  EXPECT_THAT(Of(0).fault, Is(texts::Crashed("its process 700 ended")));
  EXPECT_EQ(Of(0).health, Health::kCrashed);
}

using SentCommands = OneController;

TEST_F(SentCommands, AreQueriedThreeTimesBeforeTheActuatorIsLost) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  Pass(Milliseconds(999));
  EXPECT_EQ(Of(0).presence, Presence::kPresent);
  Pass(Milliseconds(1));
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  EXPECT_THAT(Did<action::SendQuery>(), SizeIs(6));  // three each
}

TEST_F(SentCommands, HaveNumbersAboveAllSeenNumbers) {
  StartUp();
  const CommandNumber before = machine_.number;
  ActuatorReport report = Report(0);
  report.incarnation += 100;
  report.pid += 100;
  report.epoch = 0;
  Say(0, report);
  report.epoch = machine_.epoch;
  Do(event::Replied{0, 0, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_TRUE(Of(0).command) << "it joins";
  EXPECT_EQ(Of(0).command->number, before + 1);
}

TEST_F(SentCommands, ThatACyberdogModuleExecutesInItsTimeAreNotAHang) {
  config_.actuators[0].protocol = Protocol::kCyberdog;
  config_.actuators[0].command = {"run"};
  config_.actuators[0].restart.policy = RestartPolicy::kOnFailure;
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  Obey(0);
  EXPECT_THAT(Did<action::TakeBacktrace>(), IsEmpty());
  Obey(1);
  Do(event::SetStateRequested{2, "OTA", {}});
  Pass(Milliseconds(100));
  Do(event::Replied{0, machine_.number, true, Verdict::kDone, kCodeOk, "", [&] {
                      ActuatorReport report = Report(0, "LowPower");
                      report.busy_number = machine_.number;
                      report.target = "OTA";
                      return report;
                    }()});
  EXPECT_THAT(Did<action::TakeBacktrace>(), SizeIs(1)) << "it cannot be queried";
}

using OutbidController = OneController;

TEST_F(OutbidController, WaitsAgainForAHeartbeatWhenTheActuatorWasLostMeanwhile) {
  for (ActuatorConfig& actuator : config_.actuators) {
    std::fill(actuator.times.begin(), actuator.times.end(), Duration(std::chrono::seconds(30)));
  }
  Begin();
  ActuatorReport report = Report(0);
  report.epoch = machine_.epoch + 4;
  Say(0, report);
  Do(event::Vanished{0, kFirst, false, "connection lost"});
  Pass(std::chrono::seconds(5));
  Forget();
  report.stamp = now_;
  Say(0, report);
  EXPECT_THAT(Did<action::SendQuery>(), IsEmpty()) << "a controller may lead with that epoch";
  EXPECT_LT(machine_.epoch, report.epoch);
  Pass(Milliseconds(1200));
  EXPECT_GT(machine_.epoch, report.epoch);
}

TEST_F(OutbidController, WaitsFourSecondsWhereMessagesAreSecured) {
  config_.keys = "keys";
  Begin();
  ActuatorReport report = Report(0);
  report.epoch = machine_.epoch + 4;
  Say(0, report);
  Pass(Milliseconds(3999));
  EXPECT_THAT(Did<action::SendQuery>(), IsEmpty());
  Pass(Milliseconds(1));
  EXPECT_THAT(Did<action::SendQuery>(), SizeIs(1));
}

TEST_F(OutbidController, GivesThePresentActuatorsItsHigherEpochAndStopsNoCallback) {
  Begin();
  Come(0);
  ActuatorReport report = Report(1);
  report.epoch = machine_.epoch + 4;
  Say(1, report);
  Forget();
  Pass(Milliseconds(1200));
  const auto queries = Did<action::SendQuery>();
  ASSERT_THAT(queries, SizeIs(2));
  EXPECT_EQ(queries[0].actuator, ActuatorIndex(0));
  EXPECT_EQ(queries[0].command, (QueryCommand{report.epoch + 1, 0, false}));
}

TEST_F(OutbidController, EngagesTheStopThatAnArrivingActuatorHasMissed) {
  Begin();
  Come(0);
  Do(event::EmergencyStopSeen{{7, "a panel", ""}});
  Forget();
  Come(1);
  const auto published = Did<action::PublishEmergencyStop>();
  ASSERT_FALSE(published.empty());
  EXPECT_TRUE(published[0].engaged);
  EXPECT_EQ(published[0].stop.id, StopId(7));
}

TEST_F(OutbidController, ReleasesControlWhenItsCommandIsRefusedForAHigherEpoch) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower", {}});
  ActuatorReport report = Report(0, "Active");
  report.epoch = machine_.epoch + 1;
  Do(event::Replied{0, Of(0).command.value().number, false, Verdict::kRefused,
                    kCodePermissionDenied, "of another controller", report});
  EXPECT_EQ(machine_.phase, Phase::kFenced);
  EXPECT_THAT(Did<action::SaveEpoch>(), IsEmpty());
}

TEST_F(OutbidController, RaisesItsEpochOnceAboveTheHighestThatItHasSeen) {
  Begin();
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    ActuatorReport report = Report(i);
    report.epoch = Epoch(3 + 4 * i.value());
    Say(i, report);
  }
  Forget();
  Pass(std::chrono::seconds(2));
  EXPECT_THAT(Did<action::SaveEpoch>(), SizeIs(1));
  EXPECT_EQ(machine_.epoch, Epoch(8));
  EXPECT_TRUE(IsRecorded(texts::EpochRaised(8, "b")));
}

// Each of its reports took the machine down again, also after a person had gone on without it.
TEST_F(OutbidController, TakesAReportOfAnActuatorThatAnotherOneHasForNoNewLoss) {
  config_.actuators[1].on_lost = "DeActive";
  StartUp();
  Do(event::Vanished{1, Of(1).report.incarnation, true, "it has exited"});
  ObeyAll();
  ASSERT_EQ(machine_.state, "DeActive");
  ActuatorReport report = Report(1, "Active");
  report.incarnation += 100;
  report.host = "there";
  report.epoch = machine_.epoch + 1;
  Say(1, report);
  Pass(std::chrono::seconds(5));
  ASSERT_TRUE(IsRecorded(EventName::kControlledByAnother));
  Do(event::SetStateRequested{1, "Active"});
  ObeyAll();
  ASSERT_EQ(machine_.state, "Active");
  report.stamp = now_;
  report.state = "LowPower";
  Say(1, report);
  Pass(std::chrono::seconds(5));
  EXPECT_EQ(machine_.state, "Active");
  EXPECT_FALSE(machine_.current);
}

// It went to the machine's state by itself, without its controller, and counted as well.
TEST_F(OutbidController, KeepsAnActuatorDegradedThatAControllerOfTheSameEpochHas) {
  StartUp();
  Do(event::SetStateRequested{1, "LowPower"});
  ActuatorReport report = Report(0, "Active");
  Do(event::Replied{0, Of(0).command.value().number, false, Verdict::kRefused,
                    kCodePermissionDenied, "of another controller", report});
  ObeyAll();
  ASSERT_EQ(machine_.state, "LowPower");
  const auto of_another = Is(texts::ControlledByAnother(machine_.epoch));
  EXPECT_THAT(Of(0).fault, of_another);
  Forget();
  now_ += Milliseconds(1);
  report = Report(0, "LowPower");
  Say(0, report);
  EXPECT_THAT(Of(0).fault, of_another);
  EXPECT_THAT(Did<action::SendSwitch>(), IsEmpty());
}

// An echo, or a process of another name space.
TEST_F(OutbidController, IsNotReplacedByAReportOfAProcessThatItHasNotTakenControlOf) {
  StartUp();
  ActuatorReport report = Report(0, "Active");
  report.incarnation += 100;
  report.host = "elsewhere";
  report.epoch = machine_.epoch + 1;
  Say(0, report);
  EXPECT_EQ(machine_.phase, Phase::kRunning);
}

// An older sample arrived first, or the last query of a predecessor after it: the predecessor had
// not saved its epoch.
TEST_F(OutbidController, IsNotReplacedByADenialOfItsFirstQueryOnItsOwnHost) {
  for (const bool restarted : {false, true}) {
    machine_ = MakeMachine(config_);
    event::Begin begin{false, 0, PerActuator<bool>(config_.actuators.size()), "here"};
    begin.restarted = begin.supervised = restarted;
    Do(begin);
    ActuatorReport report = Report(0);
    Say(0, report);
    report.epoch = machine_.epoch + 1;
    Do(event::Replied{0, 0, true, Verdict::kRefused, kCodePermissionDenied, "", report});
    EXPECT_EQ(machine_.phase, Phase::kStarting) << "its heartbeat would arrive here";
    Pass(Milliseconds(1200));
    EXPECT_EQ(machine_.epoch, report.epoch + 1);
  }
}

TEST_F(OutbidController, IsReplacedByADenialOfItsFirstQueryOnAnotherHost) {
  Begin();
  ActuatorReport report = Report(0);
  report.host = "elsewhere";
  Say(0, report);
  report.epoch = machine_.epoch + 1;
  Do(event::Replied{0, 0, true, Verdict::kRefused, kCodePermissionDenied, "", report});
  EXPECT_EQ(machine_.phase, Phase::kFenced);
}

TEST_F(Reports, OfAnUncommandedStateAreRecordedAsAnError) {
  StartUp();
  now_ += Milliseconds(1);
  ActuatorReport report = Report(0, "LowPower");
  report.number = report.outcome_number = Of(0).report.outcome_number;
  Say(0, report);
  EXPECT_EQ(RecordWith(texts::ActuatorDrifted("a", "LowPower", std::nullopt)).code,
            kCodeStatusError);
}

TEST_F(Reports, OfAStartingSuccessorKeepTheExitOfItsPredecessorFromARestart) {
  for (ActuatorConfig& actuator : config_.actuators) {
    actuator.command = {"run", actuator.name};
    actuator.restart.policy = RestartPolicy::kOnFailure;
  }
  Begin();
  Do(event::ProcessStarted{0, 690});
  Say(0, Report(0));  // of process 700, which another party has started
  ASSERT_EQ(Of(0).presence, Presence::kStarting);
  Do(event::ProcessEnded{0, 690, false, "exit code 1"});
  EXPECT_FALSE(Of(0).restart.at);
  EXPECT_EQ(Of(0).presence, Presence::kStarting);
}

}  // namespace musher::testing::take_control_test
