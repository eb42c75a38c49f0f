// Actuators that return after a switch out of a step of the start was undone: the machine has no
// state with a rank, and they stay where a rollback leads.

#include <gmock/gmock.h>

#include <algorithm>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::late_after_failure_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;

class LateAfterFailure : public Switching {
 protected:
  // Two actuators that a person has started; b is critical.
  static MachineConfig WithCriticalB() {
    MachineConfig config = MachineOf(2);
    ActuatorNamed(config, "b").critical = true;
    return config;
  }
  static void Unlist(MachineConfig& config, const std::string& name, const State& state) {
    ActuatorConfig& actuator = ActuatorNamed(config, name);
    const auto at = std::find(actuator.states.begin(), actuator.states.end(), state);
    actuator.times.erase(actuator.times.begin() + (at - actuator.states.begin()));
    actuator.states.erase(at);
  }

  // b needs 2 s of 100 ms for Active, so the start fails; b returns after that.
  Harness& Fail(MachineConfig config = WithCriticalB()) {
    Harness& t = harness_.emplace(std::move(config));
    t.On("b", "Active").takes = std::chrono::seconds(2);
    t.Begin();
    t.RunUntil([&] { return t.machine().phase == Phase::kFailed; });
    EXPECT_EQ(t.machine().state, "SelfCheck");
    EXPECT_TRUE(t.CoreOf("b").report.busy());
    return t;
  }
  // The same, and b was out of reach meanwhile.
  Harness& FailWithoutLink(MachineConfig config = WithCriticalB()) {
    Harness& t = harness_.emplace(std::move(config));
    t.On("b", "Active").takes = std::chrono::seconds(2);
    t.Begin();
    t.RunUntil([&] { return t.CoreOf("b").report.target == kActive; });
    t.Mute("b", true, true);
    t.RunUntil([&] { return t.machine().phase == Phase::kFailed; });
    t.RunFor(std::chrono::seconds(3));
    EXPECT_EQ(t.RecordOf("b").presence, Presence::kLost);
    EXPECT_EQ(t.StateOf("b"), "Active");
    t.Mute("b", false, false);
    t.RepeatStatus("b");
    return t;
  }

 private:
  std::optional<Harness> harness_;
};

TEST_F(LateAfterFailure, AnActuatorThatWasOverdueIsDrivenToWhereTheRollbackLeads) {
  Harness& t = Fail();
  EXPECT_EQ(t.StateOf("a"), "DeActive");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
  EXPECT_EQ(t.machine().phase, Phase::kFailed);
}

TEST_F(LateAfterFailure, AnActuatorThatWasOutOfReachIsDrivenToWhereTheRollbackLeads) {
  Harness& t = FailWithoutLink();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(LateAfterFailure, AnActuatorWithoutDeActiveIsDrivenToLowPower) {
  MachineConfig config = WithCriticalB();
  Unlist(config, "b", "DeActive");
  Harness& t = FailWithoutLink(config);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(LateAfterFailure, AnActuatorThatHasNoStateToGoBackToIsDegraded) {
  MachineConfig config = WithCriticalB();
  Unlist(config, "b", "DeActive");
  Unlist(config, "b", "LowPower");
  Harness& t = FailWithoutLink(config);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(t.RecordOf("b").fault,
              Is(texts::RollbackFailed("", texts::NoStateToGoBackTo().message)));
  EXPECT_TRUE(t.Set("Protected", "b").done()) << "a person may lower it";
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

TEST_F(LateAfterFailure, AnActuatorThatIsLowerThanThatStaysThere) {
  Harness& t = FailWithoutLink();
  t.Rest();
  t.ClearLog();
  t.GoByItself("b", "LowPower");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_THAT(t.log(), ElementsAre());
}

TEST_F(LateAfterFailure, AnActuatorThatGoesUpByItselfIsDrivenBack) {
  Harness& t = FailWithoutLink();
  t.Rest();
  t.GoByItself("b", "Protected");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

TEST_F(LateAfterFailure, AnActuatorIsDrivenBackDuringAnEmergencyStop) {
  Harness& t = Fail();
  t.StopAll(7);
  t.Rest();
  EXPECT_TRUE(t.machine().emergency.stop);
  EXPECT_EQ(t.config().RankOf(t.StateOf("b")).value_or(0), 0) << "its callback was stopped";
  t.GoByItself("b", "Active");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

TEST_F(LateAfterFailure, AnActuatorThatCannotBeDrivenBackIsDegradedAndAPersonCanLowerIt) {
  Harness& t = Fail();
  t.On("b", "DeActive").code = 5001;
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->code, 5001);
  t.ClearLog();
  EXPECT_TRUE(t.Set("LowPower", "b").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  EXPECT_TRUE(t.RecordOf("b").held);
  EXPECT_THAT(t.log(), ElementsAre("b:LowPower")) << "once, and what a person has set stays";
}

// The check clears its fault.
TEST_F(LateAfterFailure, AnActuatorThatCouldNotBeBroughtBackIsDrivenBackOnceItsCheckHasPassed) {
  Harness t(WithCriticalB());
  t.On("b", "Active").code = 5001;
  t.On("b", "Active").takes = Milliseconds(50);
  t.On("a", "DeActive").code = 5002;
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kFailed);
  EXPECT_EQ(t.StateOf("a"), "Active");
  EXPECT_THAT(t.RecordOf("a").fault, Is(EventName::kRollbackFailed));
  t.On("a", "DeActive") = {};
  EXPECT_TRUE(t.Set("SelfCheck").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("a"), "DeActive");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(LateAfterFailure, NoActuatorIsSetAboveItsOwnStateBeforeTheMachineIsUsable) {
  Harness& t = Fail();
  t.Rest();
  for (const BuiltInState state : {kActive, kProtected, kDeActive}) {
    EXPECT_EQ(t.Set(State(state), "b").outcome, SwitchOutcome::kRefused) << state;
  }
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

TEST_F(LateAfterFailure, TheMachineCanBeActivatedByHandAfterThat) {
  Harness& t = FailWithoutLink();
  t.Rest();
  t.On("b", "Active") = {};
  EXPECT_TRUE(t.Set("SelfCheck").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

// A program that drives the start by hand: it has not failed, and its first switch is undone.
TEST_F(LateAfterFailure, TheSameHoldsForAStartByHand) {
  Harness t(WithCriticalB());
  t.Begin(true);
  t.Rest();
  EXPECT_TRUE(t.Set("SelfCheck").done());
  t.On("b", "Active").takes = std::chrono::seconds(2);
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(t.machine().phase, Phase::kStarting);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
}

TEST_F(LateAfterFailure, AnActuatorThatReturnsWhileTheOthersAreBroughtBackFollowsThem) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").critical = true;
  Harness t(config);
  t.On("b", "Active").code = 5001;
  t.On("b", "Active").takes = Milliseconds(60);
  t.On("a", "DeActive").takes = Milliseconds(90);
  t.Begin();
  t.RunUntil([&] { return t.StateOf("c") == kActive; });
  t.Mute("c", true, true);
  t.RunFor(Milliseconds(5));  // what was under way arrives
  t.Find("c", Health::kPartitioned, true);
  t.RunUntil([&] { return t.machine().current && t.machine().current->rollback.under_way; });
  t.Mute("c", false, false);
  t.RepeatStatus("c");
  t.RunUntil([&] { return t.machine().phase == Phase::kFailed; });
  ASSERT_EQ(t.RecordOf("c").presence, Presence::kPresent);
  t.Rest();
  EXPECT_EQ(t.StateOf("c"), "DeActive");
}

// Error leaves an actuator that does not list it where it is; the self-check that follows clears
// its fault.
TEST_F(LateAfterFailure, AfterErrorAnActuatorThatDoesNotListItIsDrivenBackOnceItsCheckHasPassed) {
  MachineConfig config = MachineOf(2);
  Unlist(config, "b", "Error");
  Harness& t = In("Active", config);
  EXPECT_EQ(t.Set("Error").outcome, SwitchOutcome::kDoneDegraded);
  ASSERT_EQ(t.StateOf("b"), "Active");
  t.Set("SelfCheck");
  EXPECT_EQ(t.machine().state, "SelfCheck");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_THAT(t.log(), Not(Contains("b:Active")));
}

}  // namespace musher::testing::late_after_failure_test
