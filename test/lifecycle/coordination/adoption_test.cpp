// A restarted controller finds running actuators: it disturbs none, and finishes an unfinished
// switch.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::adoption_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

class Adopting : public Switching {
 protected:
  static void Restart(Harness& t, bool lost_disk = false) {
    t.RestartController(lost_disk);
    t.Rest();
  }
};

TEST_F(Adopting, DisturbsNoActuatorInWhateverStateTheMachineIs) {
  for (const BuiltInState state : {kActive, kProtected, kDeActive, kLowPower, kOta, kError}) {
    Harness& t = In(state, Ours(3));
    Restart(t);
    EXPECT_EQ(t.machine().state, state);
    EXPECT_EQ(t.machine().phase, Phase::kRunning);
    EXPECT_THAT(t.log(), IsEmpty()) << state;
    EXPECT_THAT(t.signals, IsEmpty()) << state;
  }
}

// Those that cannot dance stay in Active: they say nothing about the machine.
TEST_F(Adopting, OfTwoStatesOnOneLevelThatOfTheActuatorsWhichListBoth) {
  MachineConfig config = WithDancing(Ours(5));
  for (const char* name : {"c", "d", "e"}) {
    ActuatorNamed(config, name).states.pop_back();
    ActuatorNamed(config, name).times.pop_back();
  }
  Harness& t = In("Active", std::move(config));
  EXPECT_EQ(t.Set("Dancing").outcome, SwitchOutcome::kDoneDegraded);
  t.ClearLog();
  Restart(t);
  EXPECT_EQ(t.machine().state, "Dancing");
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(Adopting, ReportsATornDownActuatorAsTornDownAndDoesNotWaitForIt) {
  Harness& t = In("Active", Ours(3));
  t.shared.insert("b");  // its process keeps running
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.RestartController();
  const Time begun = t.now();
  ASSERT_TRUE(t.RunUntil([&] { return t.machine().phase == Phase::kRunning; }));
  EXPECT_LT(t.now() - begun, Milliseconds(50)) << "the time of its SetUp is 100 ms";
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->event, EventName::kTornDownAlone);
  EXPECT_EQ(t.StateOf("a"), "Active");
}

TEST_F(Adopting, FinishesASwitchDownInWhichThePreviousControllerCrashed) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "a").after = {"b"};  // so b goes down after a
  Harness& t = In("Active", config);
  t.On("b", "LowPower").takes = Milliseconds(90);
  t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(40));
  ASSERT_EQ(t.StateOf("a"), "LowPower");
  ASSERT_EQ(t.StateOf("b"), "Active") << "busy with it";
  Restart(t);
  EXPECT_EQ(t.machine().state, "LowPower");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "LowPower") << name;
  EXPECT_THAT(t.records, Contains(Is(EventName::kUnfinishedSwitchFound)));
}

TEST_F(Adopting, RecordsAnUnfinishedSwitchOnlyWhereThereWasOne) {
  const auto unfinished = Contains(Is(EventName::kUnfinishedSwitchFound));
  Harness& started_again = In("Protected", Ours(3));
  started_again.On("b", "Protected").takes = Milliseconds(90);
  started_again.Crash("b");
  ASSERT_TRUE(started_again.RunUntil([&] { return started_again.StateOf("b") == "SelfCheck"; }));
  started_again.RunFor(Milliseconds(20));  // busy with Protected
  Restart(started_again);
  EXPECT_THAT(started_again.records, Not(unfinished));
  EXPECT_THAT(
      started_again.records,
      Contains(Is(texts::MixedStatesFound("b in SelfCheck switching to Protected", "Protected"))));

  MachineConfig config = Ours(3);
  ActuatorNamed(config, "a").controller_lost = Milliseconds(1000);
  ActuatorNamed(config, "a").on_controller_lost = "Protected";
  Harness& fallen = In("Active", config);
  fallen.Mute("a", true, true);
  fallen.RunFor(Milliseconds(1100));
  fallen.Inject("a", actuator_event::TimePassed{});
  ASSERT_TRUE(fallen.RunUntil([&] { return fallen.StateOf("a") == "Protected"; }));
  fallen.Mute("a", false, false);
  Restart(fallen);
  EXPECT_EQ(fallen.machine().state, "Protected");
  EXPECT_THAT(fallen.records, Not(unfinished));
  EXPECT_THAT(fallen.records,
              Contains(Is(texts::MixedStatesFound("b in Active, c in Active", "Protected"))));
}

TEST_F(Adopting, RecordsAnUnfinishedRollbackToo) {
  Harness& t = In("Protected", Ours(3));
  t.On("b", "Active").code = 5001;
  t.On("b", "Protected").takes = Milliseconds(90);
  t.RequestSwitch("Active");
  t.RunFor(Milliseconds(40));
  Restart(t);
  EXPECT_THAT(t.records, Contains(Is(texts::UnfinishedSwitchFound(
                             "b in Protected switching to Protected", "Protected"))));
}

TEST_F(Adopting, DoesNotRecordWhereADetachedActuatorIs) {
  Harness& t = In("Active", Ours(3));
  ASSERT_TRUE(t.Set("LowPower", "b").done());
  Restart(t);
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kMixedStatesFound))));
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kUnfinishedSwitchFound))));
}

TEST_F(Adopting, SwitchesToTheTargetOfADownwardSwitchThoughNoActuatorIsPresentYet) {
  Harness& t = In("Active", Ours(3));
  for (const char* name : {"a", "b", "c"}) t.On(name, "LowPower").takes = Milliseconds(90);
  t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(40));
  Restart(t);
  EXPECT_EQ(t.machine().state, "LowPower");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "LowPower") << name;
}

TEST_F(Adopting, UndoesASwitchUpInWhichThePreviousControllerCrashed) {
  Harness& t = In("Protected", Ours(3));
  t.On("b", "Active").takes = Milliseconds(90);
  t.RequestSwitch("Active");
  t.RunFor(Milliseconds(40));
  ASSERT_EQ(t.StateOf("a"), "Active");
  Restart(t);
  EXPECT_EQ(t.machine().state, "Protected");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected") << name;
}

TEST_F(Adopting, AnActuatorThatWasStillStartingIsDrivenToTheMachinesState) {
  Harness& t = In("Protected", Ours(3));
  t.On("b", "Protected").takes = Milliseconds(90);
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("b") == "SelfCheck"; }));
  t.RunFor(Milliseconds(20));  // busy with Protected
  t.RestartController();
  t.RunFor(Milliseconds(20));
  EXPECT_TRUE(t.Set("LowPower").degraded.empty());
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(Adopting, KeepsADetachedActuatorDetachedAndDoesNotUseItsStateForTheMachine) {
  Harness& t = In("Active", Ours(3));
  ASSERT_TRUE(t.Set("LowPower", "b").done());
  t.ClearLog();
  Restart(t);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_TRUE(t.RecordOf("b").held);
  EXPECT_THAT(t.log(), IsEmpty());
  EXPECT_TRUE(t.Set("Protected").done());
  EXPECT_EQ(t.StateOf("b"), "LowPower") << "a switch down raises it not";
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_FALSE(t.RecordOf("b").held);
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Adopting, UsesTheStatesOfDetachedActuatorsWhereAllAreDetached) {
  Harness& t = In("Active", Ours(2));
  ASSERT_TRUE(t.Set("Protected", "a").done());
  ASSERT_TRUE(t.Set("LowPower", "b").done());
  t.ClearLog();
  Restart(t);
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
  EXPECT_EQ(t.machine().state, "LowPower");
  EXPECT_THAT(t.log(), IsEmpty());
}

TEST_F(Adopting, StartsOnlyWhatDoesNotRun) {
  Harness& t = In("Protected", Ours(3));
  t.Crash("b");
  Restart(t);
  EXPECT_THAT(t.log(), ElementsAre("b:SetUp", "b:SelfCheck", "b:Protected"));
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(Adopting, AnActuatorThatPublishesAndNeverAnswersDelaysNoOther) {
  Harness& t = In("Protected", Ours(3));
  t.Mute("b", true, true);
  Restart(t);
  EXPECT_EQ(t.machine().phase, Phase::kRunning);
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_THAT(t.RecordOf("b").fault, Is(EventName::kSetUpTimeout));
}

TEST_F(Adopting, ALostCriticalActuatorThatDoesNotComeBackTakesTheMachineDown) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "SetUp").code = 3012;
  t.Crash("b");
  Restart(t);
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(Adopting, DoesNotTakeASwitchOutOfARequestedCheckForAStart) {
  for (const State state : {kDeActive, kError, kTearDown}) {
    Harness& t = In("Error", Ours(3));
    ASSERT_TRUE(t.Set("SelfCheck").done());
    for (const char* name : {"a", "b", "c"}) t.On(name, state).takes = Milliseconds(90);
    t.ClearLog();
    t.RequestSwitch(state);
    t.RunFor(Milliseconds(40));
    Restart(t);
    EXPECT_EQ(t.machine().state, state) << "Active was not requested";
    EXPECT_THAT(t.log(), ElementsAre(std::string("a:") + state, std::string("b:") + state,
                                     std::string("c:") + state));
  }
}

TEST_F(Adopting, DetectsThatACallbackOfThePreviousControllerNeverEnds) {
  Harness& t = In("Active", MachineOf(3));
  t.On("a", "DeActive").hangs = true;
  t.RequestSwitch("DeActive");
  t.RunFor(Milliseconds(20));
  Restart(t);
  EXPECT_EQ(t.machine().state, "DeActive");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("a"));
  EXPECT_THAT(t.RecordOf("a").fault, Is(texts::FoundBusy("DeActive", Milliseconds(100))));
}

TEST_F(Adopting, RequestsAnOverdueCallbackOfThePreviousControllerToStop) {
  Harness& t = In("Active", MachineOf(3));
  t.On("a", "DeActive").ends_when_requested = true;
  t.RequestSwitch("DeActive");
  t.RunFor(Milliseconds(20));
  t.On("a", "DeActive") = {};  // the next one ends by itself
  Restart(t);
  EXPECT_EQ(t.StateOf("a"), "DeActive");
  EXPECT_THAT(t.log(), ElementsAre("a:DeActive", "b:DeActive", "c:DeActive", "a:DeActive"));
}

TEST_F(Adopting, ListsAllActuatorsAfterAnActuatorThatDoesNotStart) {
  Harness& t = In("Error", Chain());
  ASSERT_TRUE(t.Set("SelfCheck").done());
  t.On("c", "DeActive").hangs = true;
  t.RequestSwitch("DeActive");
  t.RunFor(Milliseconds(20));
  Restart(t);
  EXPECT_EQ(t.machine().state, "DeActive");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre("a", "b", "c"));
  EXPECT_THAT(t.RecordOf("a").fault,
              Is(texts::DependencyDegraded("b", t.RecordOf("b").fault->message)));
}

TEST_F(Adopting, LearnsHowACallbackOfThePreviousControllerEndedThoughTheStatusIsMissed) {
  Harness& t = In("LowPower", MachineOf(3));
  t.On("a", "Active").takes = Milliseconds(60);
  t.RequestSwitch("Active");
  t.RunFor(Milliseconds(20));
  t.RestartController();
  t.RunFor(Milliseconds(20));
  t.Mute("a", false, true);
  t.RunFor(Milliseconds(50));
  t.Mute("a", false, false);
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "LowPower") << name;
}

TEST_F(Adopting, FinishesATearDownInWhichThePreviousControllerCrashed) {
  Harness& t = In("Active", Ours(3));
  for (const char* name : {"a", "b", "c"}) t.On(name, "TearDown").takes = Milliseconds(90);
  t.RequestSwitch("TearDown");
  t.RunFor(Milliseconds(40));
  Restart(t);
  EXPECT_TRUE(t.stopped());
  ASSERT_TRUE(t.start_up());
  EXPECT_FALSE(t.usable());
  EXPECT_EQ(t.start_up()->message, texts::TearDownResumed().message);
  for (const char* name : {"a", "b", "c"}) EXPECT_FALSE(t.IsAlive(name)) << name;
}

// A signal would end a robot that walks without its TearDown.
TEST_F(Adopting, TearsDownWhatIsFoundRunningThoughItHasNotAnnouncedItselfYet) {
  Harness& t = In("Active", Ours(2));
  t.RestartController();
  const RequestId request = t.RequestSwitch("TearDown");
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return t.stopped(); }));
  EXPECT_TRUE(t.answers.at(request).done());
  EXPECT_EQ(t.answers.size(), 2U);
  EXPECT_THAT(t.log(), UnorderedElementsAre("a:TearDown", "b:TearDown"));
  EXPECT_THAT(t.signals, IsEmpty());
}

TEST_F(Adopting, StartsNothingWhileATearDownWaits) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").after = {"a"};
  Harness& t = In("Active", config);
  t.Crash("b");
  t.RestartController();
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return t.stopped(); }));
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown"));
}

TEST_F(Adopting, TearsDownWithoutWhatStaysSilentAfterThreeSeconds) {
  MachineConfig config = Ours(2);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(config.states.size(), std::chrono::seconds(10));
  }
  Harness& t = In("Active", config);
  t.Mute("b", true, true);
  t.RestartController();
  const Time begun = t.now();
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return !t.log().empty(); }));
  EXPECT_EQ(ToMilliseconds(t.now() - begun), 3000) << "of a budget of 10 s";
  ASSERT_TRUE(t.RunUntil([&] { return t.stopped(); }));
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown"));
  EXPECT_LE(t.now() - begun, config.shutdown_budget);
}

// An actuator of another protocol that a person has started holds no name by which it is found.
TEST_F(Adopting, TearsDownWhatAPersonStartedThoughItHasNotAnnouncedItselfYet) {
  MachineConfig config = MachineOf(2);
  config.transport = TransportProfile::kLan;
  Harness& t = In("Active", config);
  t.RestartController();
  const RequestId request = t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return t.stopped(); }));
  EXPECT_THAT(t.log(), UnorderedElementsAre("a:TearDown", "b:TearDown"));
  EXPECT_TRUE(t.answers.at(request).done());
}

TEST_F(Adopting, EndsAWaitingTearDownWhenAnotherControllerTakesOver) {
  Harness& t = In("Active", Ours(2));
  t.RestartController();
  const RequestId request = t.RequestSwitch("TearDown");
  t.ReceiveRivalHeartbeat(Epoch(99));
  EXPECT_EQ(t.machine().phase, Phase::kFenced);
  ASSERT_TRUE(t.answers.contains(request));
  EXPECT_FALSE(t.answers.at(request).done());
  EXPECT_THAT(t.log(), IsEmpty());
}

// The arm of the second stage goes down before the base, and the controller is killed in between.
TEST_F(Adopting, ContinuesFromTheLeastActiveStateAlsoOfALaterStage) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").after = {"a"};
  ActuatorNamed(config, "b").stage = 2;
  Harness& t = In("Active", config);
  t.On("a", "Protected").takes = Milliseconds(90);
  t.RequestSwitch("Protected");
  ASSERT_TRUE(t.RunUntil([&] { return t.StateOf("b") == "Protected"; }));
  t.DelayReports("b", Milliseconds(50));  // the base is heard first
  Restart(t);
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("a"), "Protected");
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

// A person stands beside it, and has not led it out of the check yet.
TEST_F(Adopting, LeavesAMachineThatStandsInSelfCheckThere) {
  Harness& t = In("Error", Ours(2));
  ASSERT_TRUE(t.Set("SelfCheck").done());
  t.ClearLog();
  t.RestartController(false, /*restarted=*/true);
  t.Rest();
  EXPECT_THAT(t.log(), IsEmpty()) << "Active was not requested";
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
}

// The simulation found it: a was restarted meanwhile, and is in SetUp.
TEST_F(Adopting, LeavesAMachineInSelfCheckThereBesideAnActuatorThatWasRestarted) {
  Harness& t = In("Error", Ours(2));
  ASSERT_TRUE(t.Set("SelfCheck").done());
  t.Crash("a");
  t.RestartController(false, /*restarted=*/true);
  t.ClearLog();
  t.Rest();
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_EQ(t.StateOf("b"), "SelfCheck");
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
}

// The simulation found it: a cannot go to LowPower, and the machine went on in the state of a. Then
// b, which a person had put to sleep, announced itself and was led up.
TEST_F(Adopting, LeavesAnActuatorThatIsAnnouncedLateBelowTheMachineThere) {
  MachineConfig config = Ours(2);
  std::erase(ActuatorNamed(config, "a").states, kLowPower);
  ActuatorNamed(config, "a").times.pop_back();
  Harness& t = In("Active", config);
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  ASSERT_EQ(t.StateOf("b"), "LowPower");
  t.DelayReports("b", std::chrono::seconds(2));
  t.RestartController(false, /*restarted=*/true);
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").presence == Presence::kPresent; }));
  t.Rest();
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->event, EventName::kFoundBelow);
  t.DelayReports("b", {});
  const SwitchResult set = t.Set("Active");
  EXPECT_TRUE(set.done()) << set.reason;
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// The search with two faults found it: the process of a was restarted, b announced itself later
// than in its time for SetUp, in a step of the start, and was led up.
TEST_F(Adopting, LeadsUpNothingThatIsAnnouncedInAStepOfTheStart) {
  int in_a_step = 0;
  for (int delay_ms = 0; delay_ms <= 1000; delay_ms += 10) {
    Harness& t = In("DeActive", Ours(2));
    for (const char* state : {"SelfCheck", "Active"}) t.On("a", state).takes = Milliseconds(80);
    t.Crash("a");
    t.DelayReports("b", Milliseconds(delay_ms));
    t.RestartController(false, /*restarted=*/true);
    ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("b").presence == Presence::kPresent; }));
    if (t.machine().current) ++in_a_step;
    t.Rest();
    EXPECT_EQ(t.StateOf("b"), "DeActive") << "announced " << delay_ms << " ms late";
  }
  EXPECT_GE(in_a_step, 10);
}

TEST_F(Adopting, WithALostDiskExceedsTheEpochOfTheActuators) {
  Harness& t = In("Protected", Ours(3));
  for (int i = 0; i < 4; ++i) Restart(t);
  ASSERT_EQ(t.machine().epoch, Epoch(5));
  Restart(t, /*lost_disk=*/true);
  EXPECT_EQ(t.machine().epoch, Epoch(6));
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_TRUE(t.Set("LowPower").done());
}

TEST_F(Adopting, AnActuatorThatWasSetToErrorIsLedOutThroughSelfCheck) {
  Harness& t = In("Active", Ours(3));
  ASSERT_TRUE(t.Set("Error", "b").done());
  t.ClearLog();
  Restart(t);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_THAT(t.log(), IsEmpty()) << "it was detached by a person";
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Protected").done());
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

TEST_F(Adopting, AnActuatorFoundInErrorLaterIsListedAndNotDrivenWithoutARequest) {
  Harness& t = In("Error", MachineOf(2));
  t.Mute("b", true, true);
  t.Crash("a");
  t.RunFor(Milliseconds(1));
  t.StartActuator("a");
  Restart(t);  // only a, which was restarted, is found in time
  ASSERT_EQ(t.machine().state, "Active");
  t.Mute("b", false, false);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Error");
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::SelfCheckMissing("Error")));
  t.Set("SelfCheck");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), IsEmpty());
}

// It counted as being in Error, and the outcome was done while it went to SelfCheck.
TEST_F(Adopting, AnActuatorLeavingErrorIsBroughtBackByASwitchToError) {
  Harness& t = In("Error", Ours(3));
  t.On("c", "SelfCheck").takes = Milliseconds(90);
  t.RequestSwitch("SelfCheck");
  t.RunFor(Milliseconds(40));
  t.RestartController();
  t.RunFor(Milliseconds(20));
  ASSERT_EQ(t.machine().state, "Error");
  EXPECT_TRUE(t.Set("Error").done());
  EXPECT_EQ(t.StateOf("c"), "Error");
  EXPECT_FALSE(t.CoreOf("c").report.busy()) << "the switch waits for it";
}

TEST_F(Adopting, OfAMachineInErrorIsLedOutThroughSelfCheck) {
  Harness& t = In("Error", Ours(3));
  Restart(t);
  EXPECT_EQ(t.machine().state, "Error");
  EXPECT_EQ(t.Set("Active").code, kCodeStateInvalid);
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Active") << name;
}

using AdoptingOne = OneController;

// Of those on the lowest level only b could be in both states; that c is higher does not matter.
TEST_F(AdoptingOne, OfTwoStatesOnOneLevelCountsNoStatesOfOtherLevels) {
  config_ = MachineOf(3);
  config_.states.emplace_back("Guarding");
  config_.ranks["Guarding"] = *BuiltInRank(kProtected);
  ListAllStates(config_);
  std::erase(config_.actuators[0].states, "Guarding");
  std::erase(config_.actuators[1].states, "Active");
  for (ActuatorIndex i = 0; i < 2; ++i) config_.actuators[i].times.pop_back();
  Begin();
  Come(0, "Protected");
  Come(1, "Guarding");
  Come(2, "Active");
  EXPECT_EQ(machine_.state, "Guarding");
}

// The state of a node that agrees with SetUp counts as well once a Musher actuator has a state.
TEST_F(AdoptingOne, CountsANodeThatIsLowerThanTheMusherActuators) {
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  Begin();
  Come(0, "Active");
  Come(1, "LowPower");
  EXPECT_EQ(machine_.state, "LowPower");
}

TEST_F(AdoptingOne, TearsDownWhatAPersonStartedAndListsNothingAsLeftBehind) {
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {true, true}, "here"};
  begin.processes = {700, 701};
  Do(begin);
  for (ActuatorIndex i = 0; i < 2; ++i) Come(i, "Active");
  Do(event::SetStateRequested{1, "TearDown", {}});
  ObeyAll();
  Pass(std::chrono::seconds(10));
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].result.outcome, SwitchOutcome::kDone);
  for (const action::Record& record : records_) EXPECT_EQ(record.code, kCodeOk) << record.message;
}

}  // namespace musher::testing::adoption_test
