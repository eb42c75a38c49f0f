// Switches up and down: order, failure, rollback.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::switch_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(Switching, IsDoneWhenEveryActuatorIsInTheTarget) {
  Harness& t = In("Active");
  const SwitchResult result = t.Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDone);
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.state, "LowPower");
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kDone);
  EXPECT_GE(Of(result, "b").duration, Milliseconds(10));
  EXPECT_EQ(Of(result, "b").state, "LowPower");
}

TEST_F(Switching, RunsAllAtOnceWhereNothingComesAfterAnything) {
  Harness& t = In("Active");
  const Time begun = t.now();
  t.Set("Protected");
  EXPECT_LT(t.now() - begun, Milliseconds(15));
}

TEST_F(Switching, GoesUpInTheOrderOfAfterAndDownInReverse) {
  Harness& t = In("Protected", Chain());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_THAT(t.log(), ElementsAre("c:Active", "b:Active", "a:Active"));
  t.ClearLog();
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_THAT(t.log(), ElementsAre("a:LowPower", "b:LowPower", "c:LowPower"));
}

TEST_F(Switching, ToThePresentStateDrivesOnlyTheActuatorsInOtherStates) {
  Harness& t = In("Active");
  EXPECT_TRUE(t.Set("DeActive", "b").done());
  t.ClearLog();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_THAT(t.log(), ElementsAre("b:Active"));
}

TEST_F(Switching, GivesNumbersThatOnlyGrow) {
  Harness& t = In("Active");
  const auto first = t.Set("Protected").number;
  const auto second = t.Set("Active").number;
  EXPECT_LT(first, second);
}

TEST_F(Switching, OutsideTheFlowIsRefusedWithWhatIsReachable) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("Error").done());
  const SwitchResult result = t.Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(result.code, kCodeStateInvalid);
  EXPECT_THAT(result.reason, HasSubstr("TearDown, SelfCheck"));
  EXPECT_EQ(t.machine().state, "Error");
}

TEST_F(Switching, LeavesErrorThroughASelfCheckByHand) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("Error").done());
  ASSERT_TRUE(t.Set("SelfCheck").done());
  EXPECT_EQ(t.machine().state, "SelfCheck");
  EXPECT_TRUE(t.Set("DeActive").done());
  EXPECT_TRUE(t.Set("Active").done());
}

TEST_F(Switching, ToAnUnknownStateIsRefusedAndNamesTheNearest) {
  Harness& t = In("Active");
  const SwitchResult result = t.Set("Actve");
  EXPECT_EQ(result.code, kCodeParametersInvalid);
  EXPECT_THAT(result.reason, HasSubstr("did you mean 'Active'"));
  EXPECT_EQ(t.Set("Active", "d").code, kCodeParametersInvalid);
}

// Up

TEST_F(Switching, UpIsUndoneWhenAnActuatorFails) {
  Harness& t = In("Protected");
  t.On("b", "Active").code = 5001;
  t.On("b", "Active").message = "amplifier";
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(result.code, 5001);
  EXPECT_THAT(result.reason, HasSubstr("b: failed with 5001"));
  EXPECT_THAT(result.reason, HasSubstr("amplifier"));
  EXPECT_EQ(Of(result, "a").outcome, ActuatorOutcome::kUndone);
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kFailed);
  EXPECT_EQ(t.machine().state, "Protected");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected");
  EXPECT_THAT(result.degraded, ElementsAre());
}

TEST_F(Switching, UpRunsTheOldCallbackOfTheFailedActuatorToCleanUp) {
  Harness& t = In("Protected");
  t.On("b", "Active").code = 5001;
  t.Set("Active");
  EXPECT_THAT(t.log(), ::testing::Contains("b:Protected"));
}

TEST_F(Switching, UpSendsNothingMoreAfterAFailureAndIsUndoneInReverse) {
  Harness& t = In("Protected", Chain());
  t.On("b", "Active").code = 5001;
  const SwitchResult result = t.Set("Active");
  EXPECT_THAT(t.log(), ElementsAre("c:Active", "b:Active", "b:Protected", "c:Protected"));
  EXPECT_EQ(Of(result, "a").outcome, ActuatorOutcome::kSkipped);
}

TEST_F(Switching, UpIsUndoneInTheReverseOfAfterAndNotInTheOrderOfTheConfig) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").after = {"a"};
  ActuatorNamed(config, "c").after = {"b"};
  Harness& t = In("Protected", config);
  t.On("c", "Active").code = 5001;
  t.Set("Active");
  EXPECT_THAT(t.log(), ElementsAre("a:Active", "b:Active", "c:Active", "c:Protected", "b:Protected",
                                   "a:Protected"));
}

TEST_F(Switching, UpIsRefusedBeforeAnythingIsSentWhenAnActuatorDoesNotListTheTarget) {
  MachineConfig config = MachineOf(3);
  config.states.emplace_back("Turbo");
  config.ranks["Turbo"] = 7;
  config.flow = DefaultFlow(config.states);
  for (const char* name : {"a", "c"}) {
    ActuatorNamed(config, name).states.emplace_back("Turbo");
    ActuatorNamed(config, name).times.push_back(Milliseconds(100));
  }
  Harness& t = In("Active", config);
  const SwitchResult result = t.Set("Turbo");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(result.code, kCodeUnSupport);
  EXPECT_THAT(result.reason, HasSubstr("b has no state 'Turbo'"));
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST_F(Switching, NothingBecomesMoreActiveThroughARollback) {
  Harness& t = In("LowPower");
  t.On("b", "Active").code = 5001;
  t.Set("Active");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "LowPower");
}

TEST_F(Switching, AnActuatorThatCannotBeBroughtBackIsDegraded) {
  Harness& t = In("Protected");
  t.On("b", "Active").code = 5001;
  t.On("a", "Protected").code = 3001;
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_THAT(result.degraded, ElementsAre("a"));
  EXPECT_THAT(t.RecordOf("a").fault, Is(EventName::kRollbackFailed));
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kFailed) << "not done: it is not back";
  EXPECT_EQ(result.actuators[0].code, 3001);
  EXPECT_EQ(result.actuators[0].message, t.RecordOf("a").fault->message);
  EXPECT_EQ(t.machine().state, "Protected");
}

TEST_F(Switching, ACriticalActuatorThatCannotBeBroughtBackTakesTheMachineDownToItsOnLost) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "a").on_lost = "LowPower";
  Harness& t = In("Protected", config);
  t.On("b", "Active").code = 5001;
  t.On("a", "Protected").code = 3001;
  t.Set("Active");
  t.Rest();
  EXPECT_EQ(t.machine().state, "LowPower");
}

TEST_F(Switching, UpDoesNotFailBecauseOfAnAlreadyDegradedActuator) {
  Harness& t = In("Active");
  t.On("b", "Protected").code = 5001;
  EXPECT_EQ(t.Set("Protected").outcome, SwitchOutcome::kDoneDegraded);
  t.On("b", "Active").code = 5001;
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("a"), "Active");
}

TEST_F(Switching, UpDoesNotFailBecauseOfAnActuatorThatNeedsADegradedActuator) {
  Harness& t = In("Active", Chain());
  t.On("c", "Protected").code = 5001;
  EXPECT_EQ(t.Set("Protected").outcome, SwitchOutcome::kDoneDegraded);
  t.On("c", "Active").code = 5001;
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(Of(result, "a").outcome, ActuatorOutcome::kSkipped);
  EXPECT_THAT(result.degraded, ElementsAre("a", "b", "c"));
}

// b has stayed in DeActive, below the machine.
TEST_F(Switching, ADegradedActuatorThatIsBroughtBackIsDrivenToTheStateOfTheMachine) {
  Harness& t = In("DeActive");
  t.Find("b", Health::kHung);
  t.On("b", "Protected").code = 5001;
  ASSERT_EQ(t.Set("Protected").outcome, SwitchOutcome::kDoneDegraded);
  t.Find("b", Health::kWell);
  t.RunFor(Milliseconds(100));
  ASSERT_EQ(t.StateOf("b"), "DeActive") << "it has failed once more";
  t.On("b", "Protected").code = kCodeOk;
  t.On("c", "Active").code = 3001;
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kUndone);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

// Down

TEST_F(Switching, DownContinuesWhenAnActuatorFailsAndListsIt) {
  Harness& t = In("Active", Chain());
  t.On("b", "LowPower").code = 5001;
  const SwitchResult result = t.Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.code, 5001);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
  EXPECT_EQ(t.machine().state, "LowPower");
  EXPECT_EQ(t.StateOf("a"), "LowPower");
  EXPECT_EQ(t.StateOf("c"), "LowPower");
}

TEST_F(Switching, DownContinuesWithoutAnActuatorThatDoesNotListTheTarget) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "b").states = {"SetUp", "SelfCheck", "Active", "TearDown"};
  ActuatorNamed(config, "b").times.assign(4, Milliseconds(100));
  Harness& t = In("Active", config);
  const SwitchResult result = t.Set("LowPower");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(Of(result, "b").outcome, ActuatorOutcome::kUnsupported);
  EXPECT_THAT(result.degraded, ElementsAre("b"));
  EXPECT_TRUE(t.Set("Active").done()) << "back where it has stayed all the time";
}

// One actuator

TEST_F(Switching, OneActuatorThatIsSetToTheStateOfTheMachineIsNoLongerDetached) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("Protected", "b").done());
  ASSERT_TRUE(t.Set("Active", "b").done());
  EXPECT_FALSE(t.RecordOf("b").held);
}

TEST_F(Switching, OneActuatorThatIsSetTwiceToTheSameStateStaysDetached) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("Protected", "b").done());
  ASSERT_TRUE(t.Set("Protected", "b").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

TEST_F(Switching, OneActuatorThatFailsACheckWhileDetachedIsNotTakenUpWithTheMachine) {
  Harness& t = In("Protected");
  ASSERT_TRUE(t.Set("DeActive", "b").done());
  ASSERT_TRUE(t.Set("SelfCheck").done());
  t.On("b", "SelfCheck").code = 5009;
  t.Set("SelfCheck");
  t.Set("Active");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

TEST_F(Switching, ARollbackLeadsBackToAnotherStateOfTheSameRankAsTheMachines) {
  MachineConfig config = MachineOf(2);
  config.states.emplace_back("Guarding");
  config.ranks["Guarding"] = *BuiltInRank(kProtected);
  for (const BuiltInState state : {kActive, kProtected}) {
    config.flow.push_back({state, "Guarding"});
    config.flow.push_back({"Guarding", state});
  }
  ListAllStates(config);
  Harness& t = In("Protected", config);
  ASSERT_TRUE(t.Set("Guarding", "b").done());
  t.On("a", "Active").code = 3009;
  t.On("a", "Active").takes = Milliseconds(50);
  ASSERT_EQ(t.Set("Active").outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.StateOf("b"), "Guarding") << "there it was, and it is no higher";
}

TEST_F(Switching, ASelfCheckLeavesADetachedActuatorThatHasNoneAsItIs) {
  MachineConfig config = MachineOf(2);
  ActuatorConfig& b = ActuatorNamed(config, "b");
  std::erase(b.states, "SelfCheck");
  b.times.pop_back();
  Harness& t = In("Protected", config);
  ASSERT_TRUE(t.Set("DeActive", "b").done());
  t.Set("SelfCheck");
  EXPECT_TRUE(t.RecordOf("b").held);
  EXPECT_FALSE(t.RecordOf("b").fault);
}

TEST_F(Switching, ATearDownReachesAnActuatorThatIsBeingRestarted) {
  Harness& t = In("Active", Ours(2));
  t.On("a", "TearDown").takes = Milliseconds(50);
  t.Restart("a");
  t.RunFor(Milliseconds(10));
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(Of(result, "a").outcome, ActuatorOutcome::kDone) << Of(result, "a").message;
  EXPECT_EQ(result.outcome, SwitchOutcome::kDone) << result.reason;
}

TEST_F(Switching, AnActuatorThatExitsOnItsWayBackIsListedThoughItHasRestarted) {
  MachineConfig config = Ours(3);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(actuator.times.size(), Milliseconds(2000));
  }
  Harness& t = In("Protected", config);
  t.On("a", "Active").code = 3009;
  t.On("a", "Active").takes = Milliseconds(50);
  t.On("b", "Protected").takes = Milliseconds(100);
  t.On("c", "Protected").takes = Milliseconds(1000);
  t.RequestSwitch("Active");
  ASSERT_TRUE(t.RunUntil([&] { return t.CoreOf("b").report.target == "Protected"; }));
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return !t.machine().current; }));
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->event, EventName::kRollbackFailed);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

}  // namespace musher::testing::switch_test
