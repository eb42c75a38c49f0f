// A switch that is disturbed: by time, silence, other switches, losses.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::disturbed_switch_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Time

using BackInASwitch = OneController;

TEST_F(Switching, AnOverdueActuatorIsQueriedAndItsOutcomeNotGuessed) {
  Harness& t = In("Active");
  t.On("b", "LowPower").takes = Milliseconds(200);  // of 100
  const SwitchResult result = t.Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kOverdue);
  EXPECT_EQ(Of(result, "b").code, kCodeTimeout);
  EXPECT_EQ(Of(result, "b").message, texts::StillBusy("LowPower", Milliseconds(100)).message);
}

TEST_F(Switching, ALateResultNeverChangesTheSwitchButTheActuatorIsNoLongerDegraded) {
  Harness& t = In("Active");
  t.On("b", "LowPower").takes = Milliseconds(200);
  EXPECT_THAT(t.Set("LowPower").degraded, ElementsAre("b"));
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Switching, AnOverdueActuatorOfASwitchUpIsRolledBackWithTheOthers) {
  Harness& t = In("Protected");
  t.On("b", "Active").takes = Milliseconds(150);
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kOverdue);
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Switching, AnOverdueCallbackIsRequestedToStop) {
  Harness& t = In("Protected");
  t.On("b", "Active").ends_when_requested = true;
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kUndone);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Switching, ALostReplyIsNotTakenForAFailureBecauseTheLatchedStatusReportsDone) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(5));
  t.Mute("b", false, true);  // neither its reply nor its latched status arrives …
  t.RunFor(Milliseconds(90));
  t.Mute("b", false, false);  // … until it is queried
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
  EXPECT_EQ(t.answers.begin()->second.outcome, SwitchOutcome::kDone);
}

TEST_F(Switching, AnActuatorThatDoesNotAnswerTheQueryIsLost) {
  Harness& t = In("Active");
  t.Mute("b", true, true);
  const SwitchResult result = t.Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kLost);
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kLost);
}

// The last line of its history said that it is degraded, though it was in the target.
TEST_F(Switching, ALostActuatorThatIsBackBeforeTheEndIsNotDegradedByTheEnd) {
  Harness& t = In("Active", MachineOf(2));
  t.On("a", "LowPower").takes = Milliseconds(90);
  t.On("b", "LowPower").takes = Milliseconds(50);
  const RequestId request = t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(20));
  t.Feed(event::Vanished{1, t.RecordOf("b").report.incarnation, false, "connection lost"});
  t.RunFor(Milliseconds(10));
  t.RepeatStatus("b");
  t.Rest();
  ASSERT_TRUE(t.answers.contains(request));
  EXPECT_EQ(Of(t.answers.at(request), "b").outcome, ActuatorOutcome::kLost);
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  std::vector<std::string> of_b;
  for (const action::Record& record : t.records) {
    if (record.actuator == ActuatorIndex(1)) of_b.push_back(record.message);
  }
  EXPECT_THAT(of_b.back(), HasSubstr("b is present in Active, on its way to LowPower"));
}

TEST_F(Switching, AHungActuatorDelaysTheSwitchNoLongerThanItsTimeAndTheQuery) {
  Harness& t = In("Active");
  t.On("b", "LowPower").hangs = true;
  const Time begun = t.now();
  t.Set("LowPower");
  EXPECT_LT(t.now() - begun, Milliseconds(110));
}

TEST_F(Switching, AnActuatorThatCrashesDuringTheSwitchIsDetectedAtOnce) {
  Harness& t = In("Protected");
  t.On("b", "Active").hangs = true;
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(20));
  t.Crash("b");
  t.RunUntil([&] { return t.answers.count(request) > 0; });
  const SwitchResult& result = t.answers.at(request);
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kLost);
  EXPECT_EQ(t.StateOf("a"), "Protected");
}

TEST_F(Switching, AnActuatorThatIsLostBeforeItsTurnIsNotRolledBack) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").after = {"a"};
  Harness& t = In("Protected", config);
  t.On("a", "Active").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(20));
  t.Find("b", Health::kPartitioned, true);
  t.RunFor(Milliseconds(20));
  t.Find("b", Health::kWell);  // before a has ended
  t.Rest();
  EXPECT_EQ(Of(t.answers.at(request), "b").outcome, ActuatorOutcome::kLost);
  EXPECT_EQ(Of(t.answers.at(request), "b").code, kCodeNetError);
  const CommandNumber number = t.answers.at(request).number;
  EXPECT_THAT(t.records, Contains(Is(texts::RollbackStarted(number, number + 1, 2))));
}

// A switch is not "done" when an actuator has exited after its part, while others switch.
TEST_F(Switching, AnActuatorThatCrashesAfterItsPartOfTheSwitchIsMissingInTheOutcome) {
  for (const State target : {kActive, kLowPower, kSelfCheck}) {
    for (const bool ours : {false, true}) {
      Harness& t = In("Protected", ours ? Ours(3) : MachineOf(3));
      t.On("c", target).takes = Milliseconds(80);
      const RequestId request = t.RequestSwitch(target);
      t.RunFor(Milliseconds(40));
      t.Crash("a");
      t.RunUntil([&] { return t.answers.count(request) > 0; });
      const SwitchResult& result = t.answers.at(request);
      EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded) << target << ours;
      EXPECT_EQ(result.code, kCodeNetError) << target << ours;
      EXPECT_THAT(result.reason, HasSubstr("a: ")) << target << ours;
      EXPECT_THAT(result.degraded, ElementsAre("a")) << target << ours;
    }
  }
}

// It may be restarted before the other actuators have switched.
TEST_F(Switching, AnActuatorRestartedAfterItsPartOfTheSwitchIsMissingInTheOutcome) {
  for (const State target : {kActive, kLowPower, kSelfCheck}) {
    for (const bool critical : {false, true}) {
      MachineConfig config = critical ? OursWithCriticalB() : Ours(3);
      for (ActuatorConfig& actuator : config.actuators) {
        actuator.times.assign(actuator.times.size(), Milliseconds(2000));
      }
      Harness& t = In("Protected", config);
      t.On("c", target).takes = Milliseconds(1000);
      const RequestId request = t.RequestSwitch(target);
      t.RunFor(Milliseconds(40));
      t.Crash("b");
      t.RunUntil([&] { return t.answers.count(request) > 0; });
      ASSERT_EQ(t.RecordOf("b").presence, Presence::kPresent) << target;
      const SwitchResult& result = t.answers.at(request);
      EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded) << target << critical;
      EXPECT_EQ(result.code, kCodeNetError) << target << critical;
      EXPECT_EQ(result.reason, "b: it has switched to SetUp since, and is being driven back");
      EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kLost) << target << critical;
      EXPECT_EQ(Of(result, "b").code, kCodeNetError) << target << critical;
      t.Rest();
      EXPECT_EQ(t.StateOf("b"), t.machine().state) << target << critical;
    }
  }
}

// Its Active was superseded by Error before it was answered, and its link was cut. TearDown was
// reported as done, although it had been in Active and was ended in Error without a TearDown.
TEST_F(BackInASwitch, AnActuatorThatIsLostAfterASupersededCommandMayHaveFollowedIt) {
  Begin();
  for (const ActuatorIndex i : config_.actuators.Indices()) Come(i);
  for (const ActuatorIndex i : config_.actuators.Indices()) Obey(i);
  ASSERT_EQ(Of(0).command->target, kActive);
  Do(event::SetStateRequested{1, kError, {}});
  ASSERT_EQ(Of(0).command->target, kError);
  now_ += config_.TimeFor(0, kActive);
  Do(event::TimePassed{});
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  EXPECT_EQ(Of(0).lost_in, kActive);
}

// Its Active was superseded by Error, and Error by TearDown: only Error was kept in mind.
TEST_F(BackInASwitch, AnActuatorThatIsLostAfterTwoSupersededCommandsMayHaveFollowedEither) {
  Begin();
  for (const ActuatorIndex i : config_.actuators.Indices()) Come(i);
  for (const ActuatorIndex i : config_.actuators.Indices()) Obey(i);
  ASSERT_EQ(Of(0).command->target, kActive);
  Do(event::SetStateRequested{1, kError, {}});
  Do(event::SetStateRequested{2, kTearDown, {}});
  ASSERT_EQ(Of(0).command->target, kTearDown);
  for (int seconds = 0; seconds < 60; ++seconds) {
    now_ += std::chrono::seconds(1);
    Do(event::TimePassed{});
  }
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  EXPECT_EQ(Of(0).lost_in, kActive);
}

// Its status from before the superseded command was late.
TEST_F(BackInASwitch, AnOlderStatusDoesNotMeanThatASupersededCommandIsOver) {
  Begin();
  for (const ActuatorIndex i : config_.actuators.Indices()) Come(i);
  for (const ActuatorIndex i : config_.actuators.Indices()) Obey(i);
  const CommandNumber number = Of(0).command->number;
  Do(event::SetStateRequested{1, kError, {}});
  ActuatorReport report = Of(0).report;
  report.number = number - 1;
  report.stamp = now_;
  Say(0, report);
  ASSERT_EQ(Of(0).superseded.size(), 1U);
  EXPECT_EQ(Of(0).superseded.front().target, kActive);
  report.number = number;
  Say(0, report);
  EXPECT_THAT(Of(0).superseded, IsEmpty());
}

// Error was reported as done beside legs that had been lost, were back in Active, and took part in
// nothing.
TEST_F(BackInASwitch, AnActuatorThatIsBackInAnotherStateIsMissingInTheOutcome) {
  StartUp();
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "it is silent"});
  ASSERT_EQ(Of(0).presence, Presence::kLost);
  Do(event::SetStateRequested{1, kError, {}});
  Do(event::HealthChanged{0, kFirst, Health::kWell, false, "heartbeat received again"});
  ActuatorReport report = Report(0, kActive);
  report.epoch = machine_.epoch;
  report.number = Of(0).report.number;
  Do(event::Replied{0, report.number, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_EQ(Of(0).presence, Presence::kPresent);
  Obey(1);
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(answers[0].result.reason, "a: it is back since, in Active, and follows");
  EXPECT_EQ(Of(0).command.value().target, kError);
}

TEST_F(Switching, ACriticalActuatorThatCrashesAfterItsPartIsMissingAndTakesTheMachineDown) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "a").on_lost = "Protected";
  Harness& t = In("Protected", config);
  t.On("c", "Active").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(40));
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(t.answers.at(request).reason, HasSubstr("a: "));
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(Switching, ADelayedReportDoesNotMakeLaterCommandsLookOld) {
  Harness& t = In("Active");
  t.DelayReports("b", std::chrono::seconds(2));  // longer than the budget of any command
  t.Set("Protected", "b");
  t.Rest();
  t.DelayReports("b", {});
  EXPECT_TRUE(t.Set("LowPower").done());
}

// SelfCheck

TEST_F(Switching, SelfCheckInTheRunPhaseRunsTheCallbacksAndLeavesTheState) {
  Harness& t = In("Protected");
  const SwitchResult result = t.Set("SelfCheck");
  EXPECT_TRUE(result.done());
  EXPECT_EQ(result.state, "Protected");
  EXPECT_EQ(t.StateOf("a"), "Protected");
  EXPECT_THAT(t.log(), ElementsAre("a:SelfCheck", "b:SelfCheck", "c:SelfCheck"));
}

TEST_F(Switching, SelfCheckChecksEveryActuatorThoughTheFirstFails) {
  Harness& t = In("Active", Chain());
  t.On("c", "SelfCheck").code = 1409;
  const SwitchResult result = t.Set("SelfCheck");
  EXPECT_THAT(t.log(), ElementsAre("c:SelfCheck", "b:SelfCheck", "a:SelfCheck"));
  EXPECT_EQ(result.code, 1409) << "a later success does not hide an early failure";
}

TEST_F(Switching, SelfCheckTakesSilenceForAFailureAndGivesTheWorst) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "c").critical = true;
  Harness& t = In("Active", config);
  t.On("a", "SelfCheck").code = 1409;
  t.On("b", "SelfCheck").hangs = true;
  SwitchResult result = t.Set("SelfCheck");
  EXPECT_EQ(result.code, kCodeTimeout);
  EXPECT_EQ(Of(result, "a").code, 1409);
  t.On("c", "SelfCheck").code = 3009;
  result = t.Set("SelfCheck");
  EXPECT_EQ(result.code, 3009);
}

TEST_F(Switching, AFailedCheckStaysRecordedUntilOnePasses) {
  Harness& t = In("Active");
  t.On("b", "SelfCheck").code = 1409;
  EXPECT_THAT(t.Set("SelfCheck").degraded, ElementsAre("b"));
  EXPECT_THAT(t.Set("Protected").degraded, ElementsAre("b"));
  t.On("b", "SelfCheck").code = kCodeOk;
  EXPECT_THAT(t.Set("SelfCheck").degraded, ElementsAre());
}

// One at a time

TEST_F(Switching, RefusesAnotherSwitchWhileOneIsUnderWay) {
  Harness& t = In("Active");
  const RequestId first = t.RequestSwitch("LowPower");
  const SwitchResult second = t.Set("Protected");
  EXPECT_EQ(second.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(second.code, kCodeTargetBusy);
  t.Rest();
  EXPECT_TRUE(t.answers.at(first).done());
}

TEST_F(Switching, TheSameRequestTwiceIsOneSwitch) {
  Harness& t = In("Active");
  const RequestId first = t.RequestSwitch("LowPower");
  const RequestId again = t.RequestSwitch("LowPower");
  t.Rest();
  EXPECT_TRUE(t.answers.at(first).done());
  EXPECT_EQ(t.answers.at(first).number, t.answers.at(again).number);
  EXPECT_THAT(t.log(), ElementsAre("a:LowPower", "b:LowPower", "c:LowPower"));
}

TEST_F(Switching, AMoreUrgentSwitchSupersedesAtOnceAndTheNewestCommandWaits) {
  Harness& t = In("Protected");
  t.On("b", "Active").takes = Milliseconds(50);
  const RequestId first = t.RequestSwitch("Active");
  t.RunFor(Milliseconds(20));
  const SwitchResult error = t.Set("Error");
  EXPECT_EQ(t.answers.at(first).outcome, SwitchOutcome::kSuperseded);
  EXPECT_EQ(Of(t.answers.at(first), "b").outcome, ActuatorOutcome::kSkipped);
  EXPECT_TRUE(error.done());
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Error");
}

// One actuator

TEST_F(Switching, OneActuatorIsDetachedUntilTheNextSwitchOfTheMachine) {
  Harness& t = In("Active");
  EXPECT_TRUE(t.Set("Protected", "b").done());
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Protected");
  EXPECT_TRUE(t.RecordOf("b").held);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected") << "it is not driven back without a request";
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_FALSE(t.RecordOf("b").held);
}

TEST_F(Switching, OneActuatorMayNotBeMoreActiveThanTheMachine) {
  Harness& t = In("Protected");
  const SwitchResult result = t.Set("Active", "b");
  EXPECT_EQ(result.code, kCodeStateInvalid);
  EXPECT_THAT(result.reason, HasSubstr("may not be more active"));
}

TEST_F(Switching, OneActuatorThatFailsKeepsItsState) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", "b").done());
  t.On("b", "Protected").code = 5001;
  const SwitchResult result = t.Set("Protected", "b");
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(result.state, "DeActive");
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

// Loss

TEST_F(Switching, NumbersNeverFallBehindWhatAnActuatorHasSeen) {
  Harness& t = In("Active");
  t.Inject("b", actuator_event::QueryArrived{999'999, {t.machine().epoch, 500, false}, 1});
  t.Rest();
  const SwitchResult result = t.Set("LowPower");
  EXPECT_TRUE(result.done()) << result.reason;
  EXPECT_GT(result.number, CommandNumber(500));
}

TEST_F(Switching, UpIsRefusedWhileAnActuatorIsStillSwitching) {
  Harness& t = In("Active");
  t.On("b", "LowPower").takes = Milliseconds(300);
  ASSERT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.code, kCodeTargetBusy);
  EXPECT_THAT(result.reason, HasSubstr("b is still busy with LowPower"));
  t.Rest();
  EXPECT_TRUE(t.Set("Active").done());
}

TEST_F(Switching, DownIncludesALateActuatorThatComesUpBeforeItsTurn) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "a").after = {"b"};
  Harness& t = In("Active", config);
  t.On("a", "LowPower").takes = Milliseconds(60);
  t.On("b", "Active").takes = Milliseconds(20);
  t.Crash("b");
  t.RunFor(Milliseconds(1));
  t.StartActuator("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.CoreOf("b").report.target == "Active"; }));
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(Switching, OneActuatorThatIsTornDownIsDegradedUntilItIsRestarted) {
  Harness& t = In("Active");
  EXPECT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_THAT(t.Set("LowPower").reason, HasSubstr(texts::TornDownAlone().message));
  t.StartActuator("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(Switching, ALostCriticalActuatorTakesTheMachineDownToItsOnLost) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").critical = true;
  ActuatorNamed(config, "b").on_lost = "Protected";
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("a"), "Protected");
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_THAT(result.reason, HasSubstr("critical b"));
}

TEST_F(Switching, ALostActuatorThatIsNotCriticalLeavesTheMachineDegraded) {
  Harness& t = In("Active");
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("b"));
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
}

}  // namespace musher::testing::disturbed_switch_test
