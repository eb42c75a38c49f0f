// Which actuators are waited for, how long, and what is recorded, while the machine comes up and
// goes down.

#include "musher/base/code.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::stage_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

using Stages = OneController;

// Why a is missing.
std::string AIsLate() {
  return "a: " + texts::SetUpTimeout(Milliseconds(100)).message;
}

TEST_F(Stages, AnActuatorWithoutACommandIsWaitedForAsLongAsItsSetUpMayTake) {
  Begin();
  EXPECT_EQ(Of(0).set_up_by, now_ + Milliseconds(100));
  Pass(Milliseconds(100));
  ASSERT_THAT(Did<action::StartUpEnded>(), SizeIs(1));
  EXPECT_FALSE(Did<action::StartUpEnded>()[0].usable);
}

// Its status is latched; it says nothing about the process that is about to be started by hand.
TEST_F(Stages, AnActuatorWhoseEarlierProcessWasTornDownIsWaitedForAllTheSame) {
  Begin();
  Say(1, Report(1, "TearDown"));
  Come(0);
  EXPECT_FALSE(Of(1).fault);
  EXPECT_FALSE(machine_.start_up.set_up);
  Come(1);
  ObeyAll();
  EXPECT_EQ(machine_.state, kActive);
}

TEST_F(Stages, AnActuatorOfALaterStageIsNotAwaitedInTheFirst) {
  config_.actuators[1].stage = 2;
  Begin();
  EXPECT_TRUE(Of(0).set_up_by);
  EXPECT_FALSE(Of(1).set_up_by);
}

TEST_F(Stages, AfterTheFirstAreRecordedAndNoneBeyondTheLast) {
  config_.actuators[1].stage = 2;
  Begin();
  Come(0);
  Obey(0);
  Obey(0);
  EXPECT_FALSE(IsRecorded(texts::StageStarted(1)));
  EXPECT_EQ(RecordWith(texts::StageStarted(2)).cause, RecordId(1)) << "the controller's beginning";
  Come(1);
  Obey(1);
  Obey(1);
  EXPECT_EQ(Of(1).state(), kActive);
  EXPECT_FALSE(IsRecorded(texts::StageStarted(3)));
}

// An adopted machine: a is still on its way down.
TEST_F(Stages, TheNextOneWaitsUntilAllActuatorsAreInTheStateOfTheMachine) {
  config_ = MachineOf(3);
  config_.actuators[2].stage = 2;
  config_.actuators[2].command = {"run", "c"};
  Begin();
  Come(0, "Active");
  Come(1, "DeActive");
  ASSERT_EQ(machine_.state, kDeActive);
  EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
  Obey(0);
  EXPECT_THAT(Did<action::StartProcess>(), SizeIs(1));
}

TEST_F(Stages, OfAStartByHandBeginTogetherAndAreNotRecordedOneByOne) {
  config_.actuators[1].stage = 2;
  machine_ = MakeMachine(config_);
  Do(event::Begin{/*by_hand=*/true, 0, {false, false}, "here"});
  EXPECT_TRUE(Of(1).set_up_by);
  EXPECT_FALSE(IsRecorded(EventName::kStageStarted));
}

TEST_F(Stages, ACallerThatWaitsForSetUpIsAnswered) {
  Begin();
  Do(event::SetUpAwaited{7});
  Come(0);
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
  Come(1);
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerCall>()[0].request, RequestId(7));
  EXPECT_TRUE(Did<action::AnswerCall>()[0].result.ok());
}

TEST_F(Stages, ACallerThatWaitsForSetUpGetsTheMissingActuator) {
  Begin();
  Do(event::SetUpAwaited{7});
  Come(1);
  Pass(Milliseconds(100));
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerCall>()[0].result.error().message, AIsLate());
}

// A caller that waited for SetUp after the end of the first stage got the reply that all was well.
TEST_F(Stages, ACallerThatWaitsForSetUpTooLateGetsTheMissingActuatorAtOnce) {
  Begin();
  Come(1);
  Pass(Milliseconds(100));
  Do(event::SetUpAwaited{7});
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerCall>()[0].result.error().message, AIsLate());
}

TEST_F(Stages, ACriticalActuatorOfTheFirstStageThatFailsItsCheckEndsTheStart) {
  config_.actuators[0].critical = true;
  Begin();
  Come(0);
  Come(1);
  Do(event::Replied{0, Of(0).command->number, false, Verdict::kFailed, 5009, "no", Report(0)});
  Obey(1);
  EXPECT_EQ(machine_.phase, Phase::kFailed);
}

TEST_F(Stages, ANonCriticalActuatorThatFailsOnItsWayToActiveDoesNotUndoTheStart) {
  Begin();
  Come(0);
  Come(1);
  Obey(0);
  Obey(1);
  Do(event::Replied{0, Of(0).command->number, false, Verdict::kFailed, 5001, "no",
                    Report(0, "SelfCheck")});
  Obey(1);
  EXPECT_EQ(machine_.state, kActive);
  EXPECT_EQ(machine_.phase, Phase::kRunning);
  EXPECT_EQ(Of(0).fault->code, 5001);
}

TEST_F(Stages, AnActuatorThatNeverStartedTakesTheMachineDownOnceItRunsAndAHealthyActuatorDoesNot) {
  config_.actuators[1].on_lost = "LowPower";
  Begin();
  Come(0);
  Pass(Milliseconds(100));
  Obey(0);
  Obey(0);
  ASSERT_TRUE(machine_.current);
  EXPECT_EQ(machine_.current->target, "LowPower");
  StartUp();
  EXPECT_FALSE(machine_.current);
}

TEST_F(Stages, APresentActuatorThatFailedItsCheckDoesNotTakeTheMachineDown) {
  config_.actuators[1].on_lost = "LowPower";
  Begin();
  Come(0);
  Come(1);
  Obey(0);
  Do(event::Replied{1, Of(1).command->number, false, Verdict::kFailed, 5009, "no", Report(1)});
  Obey(0);
  EXPECT_EQ(machine_.state, kActive);
  EXPECT_TRUE(Of(1).fault);
  EXPECT_FALSE(machine_.current);
}

TEST_F(Stages, ThatAreNotStartedYetDoNotTakeTheMachineDown) {
  config_.actuators[1].stage = 2;
  config_.actuators[1].on_lost = "LowPower";
  Begin();
  Come(0);
  Obey(0);
  Obey(0);
  EXPECT_FALSE(machine_.current);
}

TEST_F(Stages, AMachineBeginsInTheStateOfItsConfig) {
  config_.default_state = "DeActive";
  EXPECT_EQ(MakeMachine(config_).state, "DeActive");
  EXPECT_EQ(MakeMachine(config_).actuators[0].state(), "DeActive");
}

TEST_F(Stages, ARecordAboutTheMachineHasItsNewState) {
  config_.actuators[1].stage = 2;
  Begin();
  Come(0);
  EXPECT_EQ(RecordWith(texts::ActuatorsSetUp(1)).state, "SetUp");
  Obey(0);
  EXPECT_EQ(RecordWith(EventName::kSwitchDone).state, "SelfCheck");
  EXPECT_EQ(RecordWith(EventName::kCommandDone).state, "");
}

using Ends = OneController;

TEST_F(Ends, GiveTearDownSevenTenthsOfTheBudget) {
  for (ActuatorConfig& actuator : config_.actuators) {
    actuator.times.assign(actuator.states.size(), std::chrono::hours(1));
  }
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", {}});
  ASSERT_THAT(Did<action::SendSwitch>(), SizeIs(2));
  EXPECT_EQ(Did<action::SendSwitch>()[0].command.budget, std::chrono::seconds(7));
}

TEST_F(Ends, DoNotWaitForProcessesThatAreNotOurs) {
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", {}});
  Obey(0);
  Obey(1);
  EXPECT_EQ(machine_.phase, Phase::kStopped);
  EXPECT_THAT(Did<action::Stopped>(), SizeIs(1));
}

TEST_F(Ends, DoNotWaitLongerThanTheBudgetForAProcessThatNothingEnds) {
  for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run"};
  Begin();
  for (ActuatorIndex i = 0; i < 2; ++i) {
    Do(event::ProcessStarted{i, static_cast<std::int32_t>(700 + i.value())});
    Come(i);
  }
  Do(event::SetStateRequested{1, "TearDown", {}});
  Pass(Milliseconds(9'999));
  EXPECT_EQ(machine_.phase, Phase::kStopping);
  Pass(Milliseconds(1));
  EXPECT_EQ(machine_.phase, Phase::kStopped);
}

TEST_F(Ends, RefuseAnotherStateAtOnceWhileProcessesAreLeft) {
  for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run"};
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", {}});
  Obey(0);
  Obey(1);
  ASSERT_EQ(machine_.phase, Phase::kStopping);
  Do(event::SetStateRequested{2, "Active", {}});
  ASSERT_THAT(Did<action::AnswerSetState>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerSetState>()[0].result.code, kCodeStateInvalid);
}

TEST_F(Ends, DoNotListAnActuatorThatIsTornDownBeforeItsTurn) {
  config_.actuators[1].stage = 2;
  StartUp();
  Do(event::SetStateRequested{1, "TearDown", {}});
  ASSERT_FALSE(Of(0).command) << "the last stage comes first";
  ActuatorReport report = Of(0).report;
  report.state = "TearDown";
  Say(0, report);
  EXPECT_THAT(Degraded(config_, machine_), IsEmpty());
}

TEST_F(Ends, TakeOverFromASwitchToError) {
  StartUp();
  Do(event::SetStateRequested{1, "Error", {}});
  Do(event::SetStateRequested{2, "TearDown", {}});
  EXPECT_EQ(machine_.phase, Phase::kStopping);
}

TEST_F(Stages, ACallerThatWaitsForSetUpGetsATimeout) {
  Begin();
  Do(event::SetUpAwaited{7});
  Come(1);
  Pass(Milliseconds(100));
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerCall>()[0].result.error().code, kCodeTimeout);
}

TEST_F(Stages, AStartByAManagerWithoutAnyActuatorFailsWithTheReasonOfTheFirst) {
  config_.ros2.started_by_manager = true;
  Begin();
  Pass(Milliseconds(100));
  const auto ended = Did<action::StartUpEnded>();
  ASSERT_THAT(ended, SizeIs(1));
  EXPECT_FALSE(ended[0].usable);
  EXPECT_THAT(ended[0].message, ::testing::HasSubstr(AIsLate()));
}

TEST_F(Stages, AnActuatorThatReportsTearDownAfterItWasGivenUpIsListedAsBefore) {
  machine_ = MakeMachine(config_);
  Do(event::Begin{false, 0, {true, true}, "here"});
  Come(0);
  Pass(Milliseconds(100));
  ASSERT_TRUE(Of(1).fault);
  ASSERT_EQ(Of(1).fault->event, EventName::kSetUpTimeout);
  Say(1, Report(1, "TearDown"));
  EXPECT_EQ(Of(1).fault->event, EventName::kSetUpTimeout);
}

}  // namespace musher::testing::stage_test
