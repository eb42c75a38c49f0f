// A plan alone: which actuators are driven, left out or refused, for a machine described here.

#include "musher/lifecycle/switch/plan.hpp"

#include <gmock/gmock.h>

#include "musher/base/code.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::plan_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Part = PlanStep::Part;

// A machine in DeActive whose actuators a, b, c, d are present, checked and well.
class Plans : public ::testing::Test {
 protected:
  Plans() {
    machine_.phase = Phase::kRunning;
    machine_.start_up.set_up = true;
    machine_.state = State(kDeActive);
    machine_.actuators.resize(4);
    for (KnownActuator& known : machine_.actuators) {
      known.presence = Presence::kPresent;
      known.checked = true;
      known.report.state = State(kDeActive);
    }
  }

  Plan To(std::string_view target) const { return MakePlan(config_, machine_, State(target)); }
  Plan Of(ActuatorIndex i, std::string_view target) const {
    return MakePlan(config_, machine_, State(target), i);
  }
  // A state of the same rank as `like`, which leads to it.
  void AddState(const State& state, std::string_view like) {
    config_.states.push_back(state);
    config_.ranks[state] = *BuiltInRank(like);
    config_.flow.push_back({State(like), state});
    for (ActuatorConfig& actuator : config_.actuators) {
      actuator.states.push_back(state);
      actuator.times.push_back(Milliseconds(100));
    }
  }
  void PutAllIn(std::string_view state) {
    machine_.state = State(state);
    for (KnownActuator& known : machine_.actuators) known.report.state = State(state);
  }
  static std::int32_t CodeOf(const Plan& plan) {
    return plan.refusal ? plan.refusal->code : kCodeOk;
  }

  MachineConfig config_ = MachineOf(4);
  Machine machine_;
};

// The second process of an actuator, in LowPower, was in use once the first one was lost, and the
// fallback for that loss led it up.
TEST_F(Plans, ForSafetyRaiseNothingThatWasFoundLessActive) {
  PutAllIn(kProtected);
  machine_.actuators[1].report.state = State(kLowPower);
  machine_.actuators[1].found_below = true;
  const Plan plan = MakeSafetyPlan(config_, machine_, State(kDeActive));
  ASSERT_EQ(plan.steps.size(), 4U);
  EXPECT_TRUE(plan.steps[0].driven());
  EXPECT_EQ(plan.steps[1].part, Part::kLeftOut);
}

TEST_F(Plans, HaveFromStateToStateAndDeadline) {
  config_.actuators[2].times.assign(config_.states.size(), Milliseconds(700));
  const Plan plan = To(kActive);
  ASSERT_EQ(plan.steps.size(), 4U);
  EXPECT_EQ(plan.steps[2].from, kDeActive);
  EXPECT_EQ(plan.steps[2].target, kActive);
  EXPECT_EQ(plan.steps[2].deadline, Milliseconds(700));
  EXPECT_EQ(plan.steps[2].wave, 1);
}

TEST_F(Plans, NeedTheActuatorsBehindAnUndrivenActuatorOnceAlsoInADiamond) {
  config_.actuators[0].after = {"b", "c"};
  config_.actuators[1].after = {"d"};
  config_.actuators[2].after = {"d"};
  for (const ActuatorIndex there : {ActuatorIndex(1), ActuatorIndex(2)})
    machine_.actuators[there].report.state = State(kActive);
  const Plan plan = To(kActive);
  EXPECT_EQ(plan.steps[1].part, Part::kInTarget);
  EXPECT_THAT(plan.steps[0].needs, ElementsAre(ActuatorIndex(3)));
  EXPECT_EQ(plan.steps[0].wave, 2);
  EXPECT_THAT(plan.steps[3].needs, IsEmpty());
  EXPECT_EQ(plan.steps[3].wave, 1);
}

TEST_F(Plans, OfABusyActuatorAreRefusedWhetherReportedOrCommanded) {
  machine_.actuators[1].report.target = State(kLowPower);
  EXPECT_EQ(CodeOf(Of(1, kLowPower)), kCodeTargetBusy);
  machine_.actuators[1].report.target = {};
  EXPECT_EQ(CodeOf(Of(1, kLowPower)), kCodeOk);
  machine_.actuators[1].command = PendingCommand{};
  EXPECT_EQ(CodeOf(Of(1, kLowPower)), kCodeTargetBusy);
}

TEST_F(Plans, OfABusyActuatorOutsideTheFlowWaitForTheStateItReachesUnlessASwitchIsUnderWay) {
  config_.flow.clear();
  machine_.actuators[1].command = PendingCommand{1, State(kLowPower), {}, {}, 0};
  EXPECT_EQ(CodeOf(Of(1, kOta)), kCodeTargetBusy);
  machine_.current.emplace();
  EXPECT_EQ(CodeOf(Of(1, kOta)), kCodeStateInvalid);
}

TEST_F(Plans, OfAMachineThatIsTornDownAreRefused) {
  for (const Phase phase : {Phase::kStopping, Phase::kStopped}) {
    machine_.phase = phase;
    EXPECT_EQ(CodeOf(To(kLowPower)), kCodeStateInvalid);
  }
}

TEST_F(Plans, OfAnActuatorThatIsBeingRestartedAreRefused) {
  machine_.actuators[1].restart.requested = true;
  EXPECT_EQ(CodeOf(Of(1, kLowPower)), kCodeTargetBusy);
}

TEST_F(Plans, OfAnActuatorThatHasNotPassedItsCheckGoDownButNotUp) {
  machine_.actuators[1].checked = false;
  machine_.actuators[1].report.state = State(kLowPower);
  EXPECT_EQ(CodeOf(Of(1, kDeActive)), kCodeSelfCheckFailed);
  EXPECT_EQ(CodeOf(Of(1, kOta)), kCodeOk);
}

TEST_F(Plans, ThatAreRefusedNameTheNextStep) {
  config_.actuators[1].command = {"b"};
  machine_.actuators[1].checked = false;
  machine_.actuators[1].report.state = State(kLowPower);
  EXPECT_EQ(Of(1, kDeActive).refusal->message,
            "b has not passed its self-check; run `musher set SelfCheck`");
  config_.actuators[1].critical = true;
  EXPECT_EQ(To(kActive).refusal->message,
            "critical b has not passed its self-check; run `musher set SelfCheck`");
  machine_.actuators[1].report.state = State(kTearDown);
  EXPECT_EQ(Of(1, kSelfCheck).refusal->message,
            "b cannot go from TearDown to SelfCheck; no state follows TearDown: `musher restart b` "
            "starts it again");
  machine_.actuators[1].presence = Presence::kLost;
  EXPECT_EQ(To(kActive).refusal->message,
            "critical b is not available: `musher restart b` starts it again");
  config_.actuators[1].command.clear();  // the controller does not start it
  EXPECT_EQ(To(kActive).refusal->message, "critical b is not available");
}

TEST_F(Plans, OfASuspendedActuatorDoNotGoUp) {
  machine_.actuators[1].suspended = true;
  machine_.actuators[1].report.state = State(kLowPower);
  EXPECT_EQ(CodeOf(Of(1, kDeActive)), kCodeStatusError);
  EXPECT_EQ(CodeOf(Of(1, kOta)), kCodeOk);
}

TEST_F(Plans, DownIncludeAnUncheckedActuatorInAStateWithARank) {
  machine_.actuators[0].checked = machine_.actuators[1].checked = false;
  machine_.actuators[1].report.state = State(kSetUp);
  const Plan plan = To(kLowPower);
  EXPECT_EQ(plan.steps[0].part, Part::kDriven);
  EXPECT_EQ(plan.steps[1].part, Part::kLeftOut);
  EXPECT_THAT(plan.steps[1].note, HasSubstr("self-check"));
}

TEST_F(Plans, UpAreRefusedForABusyActuatorUnlessASwitchIsUnderWayThatWillEnd) {
  machine_.actuators[0].report.target = State(kLowPower);
  EXPECT_EQ(CodeOf(To(kActive)), kCodeTargetBusy);
  EXPECT_EQ(CodeOf(To(kLowPower)), kCodeOk);
  machine_.current.emplace();
  EXPECT_EQ(CodeOf(To(kActive)), kCodeOk);
}

TEST_F(Plans, LeaveOutAnOverdueCyberdogModuleBecauseItCannotBeQueried) {
  config_.actuators[0].protocol = Protocol::kCyberdog;
  machine_.actuators[0].report.target = State(kOta);
  machine_.actuators[0].fault = ActuatorFault{kCodeTimeout, "overdue"};
  EXPECT_EQ(To(kLowPower).steps[0].part, Part::kLeftOut);
  machine_.actuators[0].command = PendingCommand{1, State(kOta), {}, {}, 0};
  EXPECT_EQ(To(kLowPower).steps[0].part, Part::kDriven) << "it may answer in time";
  machine_.actuators[0].command.reset();
  for (const Protocol other : {Protocol::kMusher, Protocol::kRos2Lifecycle}) {
    config_.actuators[0].protocol = other;
    EXPECT_EQ(To(kLowPower).steps[0].part, Part::kDriven);
  }
}

TEST_F(Plans, DistinguishActuatorsInTheTargetFromDetachedOnesInTheTarget) {
  machine_.actuators[0].report.state = machine_.actuators[1].report.state = State(kLowPower);
  machine_.actuators[1].held = true;
  const Plan plan = To(kLowPower);
  EXPECT_EQ(plan.steps[0].part, Part::kInTarget);
  EXPECT_EQ(plan.steps[1].part, Part::kHeldInTarget);
  EXPECT_EQ(plan.steps[2].part, Part::kDriven);
}

TEST_F(Plans, DriveADegradedActuatorInTheTargetOnceMore) {
  machine_.actuators[0].report.state = machine_.actuators[1].report.state = State(kLowPower);
  machine_.actuators[0].fault = ActuatorFault{kCodeFailed, "it stumbled"};
  machine_.actuators[1].report.target = State(kDeActive);
  const Plan plan = To(kLowPower);
  EXPECT_EQ(plan.steps[0].part, Part::kDriven);
  EXPECT_EQ(plan.steps[1].part, Part::kDriven);
  EXPECT_EQ(Of(0, kLowPower).steps[0].part, Part::kDriven);
}

TEST_F(Plans, OfATearDownOutOfAStartGoDownInTheReverseOrder) {
  config_.actuators[0].after = {"b"};
  PutAllIn(kSetUp);
  const Plan plan = To(kTearDown);
  EXPECT_EQ(plan.direction, Direction::kDown);
  EXPECT_THAT(plan.steps[1].needs, ElementsAre(ActuatorIndex(0)));
}

TEST_F(Plans, ToAStateOfTheSameRankGoNeitherUpNorDown) {
  AddState("Sitting", kDeActive);
  config_.actuators[0].after = {"b"};
  const Plan plan = To("Sitting");
  EXPECT_EQ(CodeOf(plan), kCodeOk);
  EXPECT_EQ(plan.direction, Direction::kLevel);
  EXPECT_THAT(plan.steps[0].needs, ElementsAre(ActuatorIndex(1)));
}

// That actuator refuses itself; the others become less active.
TEST_F(Plans, DownAreNotRefusedDuringAnEmergencyStopForAnActuatorThatWouldHaveToComeUp) {
  machine_.emergency.stop = EmergencyStop{7, "the test", ""};
  machine_.actuators[1].report.state = State(kOta);
  machine_.actuators[1].held = true;
  EXPECT_EQ(CodeOf(To(kLowPower)), kCodeOk);
  EXPECT_EQ(CodeOf(To(kActive)), kCodeProtectedError);
}

// As that of the present state, its callback may switch on again what the stop has switched off.
TEST_F(Plans, ToAStateOfTheSameRankAreRefusedDuringAnEmergencyStopAboveDeActive) {
  AddState("Dancing", kActive);
  AddState("Sitting", kLowPower);
  machine_.emergency.stop = EmergencyStop{7, "the test", ""};
  PutAllIn(kActive);
  ASSERT_TRUE(To("Dancing").refusal);
  EXPECT_EQ(To("Dancing").refusal->code, kCodeProtectedError);
  EXPECT_THAT(To("Dancing").refusal->message, HasSubstr("it holds Active"));
  PutAllIn(kLowPower);
  EXPECT_EQ(CodeOf(To("Sitting")), kCodeOk);
}

// Such a request is obeyed however late it comes.
TEST_F(Plans, DownRaiseNothingUnlessAnActuatorRestsLower) {
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("LowPower")));
  EXPECT_TRUE(OnlyLowers(config_, machine_, Of(1, "LowPower")));
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("TearDown")));
  for (const char* target : {"Active", "DeActive", "SelfCheck", "Nowhere"}) {
    EXPECT_FALSE(OnlyLowers(config_, machine_, To(target))) << target;
  }
  PutAllIn("Active");
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("DeActive")));
  machine_.actuators[2].report.state = State(kLowPower);
  EXPECT_FALSE(OnlyLowers(config_, machine_, To("DeActive")));
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("LowPower")));
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("TearDown")));
}

// A late request would raise it once it is free.
TEST_F(Plans, DownOfABusyActuatorRaiseNothingIfItIsOnItsWayToNoLowerState) {
  PutAllIn("Active");
  machine_.actuators[1].report.target = State(kDeActive);
  machine_.actuators[1].free_by = Time(std::chrono::seconds(5));
  EXPECT_TRUE(OnlyLowers(config_, machine_, Of(1, "DeActive")));
  EXPECT_TRUE(OnlyLowers(config_, machine_, Of(1, "LowPower")));
  machine_.actuators[1].report.target = State(kLowPower);
  EXPECT_FALSE(OnlyLowers(config_, machine_, Of(1, "DeActive")));
  EXPECT_FALSE(OnlyLowers(config_, machine_, To("DeActive")));
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("LowPower")));
}

// A late "LowPower" was refused beside a faulty actuator that lies there already. Its callback runs
// once more, as one of Protected would, which may switch on.
TEST_F(Plans, DownBesideAFaultyActuatorThatRestsInTheTargetRaiseNothingAtDeActiveOrBelow) {
  for (const bool held_by_stop : {false, true}) {
    for (const auto& target : {kProtected, kDeActive, kLowPower}) {
      PutAllIn("Active");
      KnownActuator& one = machine_.actuators[1];
      one.report.state = State(target);
      EXPECT_TRUE(OnlyLowers(config_, machine_, To(target.name()))) << target;
      one.report.held_by_stop = held_by_stop;
      if (!held_by_stop) one.fault = ActuatorFault{kCodeFailed, "it stumbled"};
      ASSERT_EQ(To(target.name()).steps[1].part, Part::kDriven);
      EXPECT_EQ(OnlyLowers(config_, machine_, To(target.name())), target != kProtected) << target;
      one.report.held_by_stop = false;
      one.fault.reset();
    }
  }
}

// As an emergency stop forbids it.
TEST_F(Plans, DownBesideAnActuatorInErrorRaiseItUnlessTheyLeaveItOut) {
  PutAllIn("Active");
  machine_.actuators[1].report.state = State(kError);
  EXPECT_FALSE(OnlyLowers(config_, machine_, To("LowPower")));
  machine_.actuators[1].checked = false;
  EXPECT_TRUE(OnlyLowers(config_, machine_, To("LowPower")));
}

TEST_F(Plans, UpAreRefusedWithoutWaitingForABusyActuatorThatHasNoDeadline) {
  machine_.actuators[0].report.target = machine_.actuators[1].report.target = State(kLowPower);
  machine_.actuators[1].free_by = Time(std::chrono::seconds(5));
  EXPECT_EQ(CodeOf(To(kActive)), kCodeTargetBusy);
  EXPECT_FALSE(To(kActive).free_by);
  machine_.actuators[0].free_by = Time(std::chrono::seconds(3));
  EXPECT_EQ(To(kActive).free_by, Time(std::chrono::seconds(5)));
}

TEST_F(Plans, OfAnActuatorWithoutTheTargetAreRefusedAndListItsStates) {
  config_.actuators[1].states = {State(kSetUp), State(kDeActive), State(kTearDown)};
  EXPECT_EQ(Of(1, kLowPower).refusal,
            (Error{kCodeUnSupport, "b has no state 'LowPower'; it has SetUp, DeActive, TearDown"}));
}

// It was torn down by itself while it was being driven on its own.
TEST_F(Plans, CountATornDownActuatorAsInTheTargetOfATearDownOnly) {
  machine_.actuators[1].report.state = State(kTearDown);
  machine_.actuators[1].command = PendingCommand{1, State(kDeActive), {}, {}, 0};
  EXPECT_EQ(Of(1, kLowPower).steps[0].part, Part::kDriven);
  EXPECT_EQ(Of(1, kTearDown).steps[0].part, Part::kInTarget);
  machine_.actuators[1].command.reset();
  EXPECT_EQ(To(kTearDown).steps[1].part, Part::kInTarget);
  EXPECT_EQ(To(kLowPower).steps[1].part, Part::kLeftOut);
}

TEST_F(Plans, OfTheCheckOfAStartIncludeADegradedActuatorUnlessItIsAnUnconfiguredNode) {
  machine_.phase = Phase::kStarting;
  PutAllIn(kSetUp);
  for (const ActuatorIndex i : {ActuatorIndex(0), ActuatorIndex(1)})
    machine_.actuators[i].fault = ActuatorFault{kCodeFailed, "it hung"};
  config_.actuators[1].protocol = Protocol::kRos2Lifecycle;
  machine_.actuators[1].report.state = config_.default_state;
  const Plan plan = To(kSelfCheck);
  EXPECT_EQ(plan.steps[0].part, Part::kDriven);
  EXPECT_EQ(plan.steps[1].part, Part::kLeftOut);
}

TEST_F(Plans, IncludeAnUncheckedActuatorThatLeavesErrorOnlyWhereTheyLeadBackToError) {
  machine_.actuators[0].checked = machine_.actuators[1].checked = false;
  machine_.actuators[0].report.state = State(kError);
  machine_.actuators[1].report.state = State(kSelfCheck);
  for (const ActuatorIndex i : {ActuatorIndex(0), ActuatorIndex(1)})
    machine_.actuators[i].report.target = State(kLowPower);
  EXPECT_EQ(To(kError).steps[0].part, Part::kDriven);
  EXPECT_EQ(To(kError).steps[1].part, Part::kLeftOut);
  EXPECT_EQ(To(kLowPower).steps[0].part, Part::kLeftOut);
}

TEST_F(Plans, UpAreRefusedForALostCriticalActuatorButNotForAStartingOne) {
  config_.actuators[0].critical = true;
  machine_.actuators[0].presence = Presence::kLost;
  EXPECT_EQ(CodeOf(To(kActive)), kCodeStatusError);
  EXPECT_EQ(CodeOf(To(kLowPower)), kCodeOk);
  machine_.actuators[0].presence = Presence::kStarting;
  EXPECT_EQ(CodeOf(To(kActive)), kCodeOk);
  EXPECT_EQ(To(kActive).steps[0].note, "is still starting");
}

TEST_F(Plans, LeaveOutALateActuatorInItsFirstCheckUnlessTheMachineEnds) {
  machine_.actuators[0].checked = false;
  machine_.actuators[0].command = PendingCommand{1, State(kSelfCheck), {}, {}, 0};
  EXPECT_EQ(To(kLowPower).steps[0].note, "is still starting");
  EXPECT_EQ(To(kError).steps[0].part, Part::kDriven);
  EXPECT_EQ(To(kTearDown).steps[0].part, Part::kDriven);
}

TEST_F(Plans, UpWaitForAnActuatorWhoseSelfCheckIsRepeated) {
  PutAllIn(kLowPower);
  const Time deadline = Time(std::chrono::hours(1));
  machine_.actuators[0].command = PendingCommand{1, State(kSelfCheck), {}, deadline, 0};
  EXPECT_EQ(To(kActive).free_by, deadline);
  EXPECT_EQ(To(kActive).steps[0].part, Part::kDriven);
}

TEST_F(Plans, DriveAnUncheckedActuatorToErrorWhileItsSelfCheckRuns) {
  machine_.actuators[1].checked = false;
  machine_.actuators[1].report.state = State(kSelfCheck);
  EXPECT_EQ(To(kError).steps[1].part, Part::kLeftOut);
  machine_.actuators[1].command = PendingCommand{1, State(kSelfCheck), {}, {}, 0};
  EXPECT_EQ(To(kError).steps[1].part, Part::kDriven);
  EXPECT_EQ(To(kLowPower).steps[1].part, Part::kLeftOut);
}

}  // namespace musher::testing::plan_test
