// binds_to: an actuator is suspended while an actuator that it needs is not up.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::binding_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Not;

class Binding : public Switching {
 protected:
  // b is bound to a and comes after it; c is independent.
  static MachineConfig Bound() {
    MachineConfig config = Ours(3);
    ActuatorNamed(config, "b").after = {"a"};
    ActuatorNamed(config, "b").binds_to = {"a"};
    return config;
  }
};

TEST_F(Binding, TakesTheDependentDownAndUpAroundTheRestart) {
  Harness& t = In("Active", Bound());
  t.Crash("a");
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("b:DeActive", "a:SetUp", "a:SelfCheck", "a:Active", "b:Active"));
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Binding, HoldsUntilTheOtherIsActiveAgainAndNotOnlyPresent) {
  MachineConfig config = Bound();
  ActuatorNamed(config, "b").after = {};
  Harness& t = In("Active", config);
  t.On("a", "Active").takes = Milliseconds(60);
  t.Crash("a");
  ASSERT_TRUE(t.RunUntil([&] { return t.CoreOf("a").report.target == "Active"; }));
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  t.RunFor(Milliseconds(40));
  EXPECT_FALSE(t.CoreOf("b").report.busy());
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("b:DeActive", "a:SetUp", "a:SelfCheck", "a:Active", "b:Active"));
}

TEST_F(Binding, HoldsWhereTheOtherIsBackAndFailsToBecomeActive) {
  Harness& t = In("Active", Bound());
  t.On("a", "Active").code = 3001;
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  t.On("a", "Active").code = kCodeOk;
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kDoneDegraded) << "b comes up after a";
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

// Less active than the machine was, and more active than the suspended actuator.
TEST_F(Binding, ASuspendedActuatorIsNotRaisedByASwitchDownNorByThePresentState) {
  Harness& t = In("Active", Bound());
  t.On("a", "SetUp").code = 3001;
  t.Crash("a");
  t.Rest();
  t.ClearLog();
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(t.Set("Protected").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_THAT(t.log(), ElementsAre("c:Protected"));
}

TEST_F(Binding, LeavesActuatorsWithoutBindsToAlone) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "b").after = {"a"};
  Harness& t = In("Active", config);
  t.Crash("a");
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("a:SetUp", "a:SelfCheck", "a:Active"));
}

TEST_F(Binding, RecordsWhyAnActuatorIsSuspended) {
  Harness& t = In("Active", Bound());
  t.On("a", "SetUp").code = 3001;
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::NotUp("a")));
  EXPECT_EQ(t.StateOf("c"), "Active");
}

TEST_F(Binding, AnActuatorWithoutDeActiveIsSuspendedInLowPower) {
  MachineConfig config = Bound();
  ActuatorConfig& b = ActuatorNamed(config, "b");
  std::erase(b.states, State(kDeActive));
  b.times.resize(b.states.size());
  Harness& t = In("Active", config);
  t.Crash("a");
  t.RunFor(Milliseconds(50));
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

TEST_F(Binding, IsTransitive) {
  MachineConfig config = Bound();
  ActuatorNamed(config, "c").after = {"b"};
  ActuatorNamed(config, "c").binds_to = {"b"};
  Harness& t = In("Active", config);
  t.Crash("a");
  t.RunFor(Milliseconds(50));
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_EQ(t.StateOf("c"), "DeActive");
  t.Rest();
  EXPECT_THAT(std::vector(t.log().end() - 3, t.log().end()),
              ElementsAre("a:Active", "b:Active", "c:Active"));
}

TEST_F(Binding, OfTwoToEachOtherKeepsNeitherDownForEver) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "a").binds_to = {"b"};
  ActuatorNamed(config, "b").binds_to = {"a", "c"};
  Harness& t = In("Active", config);
  t.Crash("a");
  t.RunFor(Milliseconds(50));
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  t.Rest();
  t.Crash("c");
  t.RunFor(Milliseconds(50));
  EXPECT_EQ(t.StateOf("a"), "DeActive");
  t.Rest();
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Active") << name;
}

TEST_F(Binding, AHungActuatorTakesItsDependentsDownToo) {
  MachineConfig config = MachineOf(2);  // without a command: the controller cannot restart them
  ActuatorNamed(config, "b").binds_to = {"a"};
  Harness& t = In("Active", config);
  t.Find("a", Health::kHung);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  t.Find("a", Health::kWell);
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(Binding, ASelfCheckThatFailsAfterTheReturnKeepsTheDependentSuspended) {
  Harness& t = In("Active", Bound());
  t.On("a", "SelfCheck").code = 3009;
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  t.On("a", "SelfCheck").code = kCodeOk;
  const SwitchResult check = t.Set("SelfCheck");
  EXPECT_TRUE(check.done()) << "all have passed it";
  EXPECT_THAT(check.degraded, ElementsAre("b")) << "which still rests";
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

TEST_F(Binding, ASuspendedActuatorIsLeftOutOfASwitchUpAndListedInTheResult) {
  Harness& t = In("Protected", Bound());
  t.On("a", "SetUp").code = 3001;
  t.Crash("a");
  t.Rest();
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, IsSupersetOf({"a", "b"}));
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_THAT(t.Set("Active", "b").reason, HasSubstr("is suspended until"));
}

TEST_F(Binding, ASuspendedActuatorGoesFurtherDownWithTheMachine) {
  Harness& t = In("Active", Bound());
  t.On("a", "SetUp").code = 3001;
  t.Crash("a");
  t.Rest();
  t.Set("LowPower");
  EXPECT_EQ(t.StateOf("b"), "LowPower");
  t.Set("Protected");
  EXPECT_EQ(t.StateOf("b"), "LowPower") << "and does not follow up";
}

TEST_F(Binding, ADetachedActuatorKeepsItsState) {
  Harness& t = In("Active", Bound());
  ASSERT_TRUE(t.Set("Protected", "b").done());
  t.ClearLog();
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Protected");
  EXPECT_THAT(t.log(), ElementsAre("a:SetUp", "a:SelfCheck", "a:Active"));
}

TEST_F(Binding, IsNotUpWhereAPersonHasSetItAloneToRest) {
  for (const State& rest : {State("DeActive"), State("LowPower")}) {
    Harness& t = In("Active", Bound());
    ASSERT_TRUE(t.Set(rest, "a").done());
    t.Rest();
    EXPECT_EQ(t.StateOf("b"), "DeActive") << rest;
    EXPECT_THAT(t.RecordOf("b").fault, Is(texts::NotUp("a"))) << rest;
    ASSERT_TRUE(t.Set("Active", "a").done());
    t.Rest();
    EXPECT_EQ(t.StateOf("b"), "Active") << "the person has led it up again, from " << rest;
  }
}

TEST_F(Binding, IsUpWhereAPersonHasSetItAloneAboveRestOrTheMachineRests) {
  Harness& t = In("Active", Bound());
  ASSERT_TRUE(t.Set("Protected", "a").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
  ASSERT_TRUE(t.Set("DeActive").done());
  ASSERT_TRUE(t.Set("LowPower", "a").done());
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_FALSE(t.RecordOf("b").fault);
}

TEST_F(Binding, AnActuatorThatIsSlowToGoDownIsSuspendedAnyway) {
  Harness& t = In("Active", Bound());
  t.On("a", "SetUp").code = 3001;
  t.On("b", "DeActive").takes = Milliseconds(180);  // of 100
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "DeActive");
  EXPECT_TRUE(t.RecordOf("b").fault) << "that it was late does not hide why it rests";
}

TEST_F(Binding, WaitsForASwitchUnderWay) {
  Harness& t = In("Active", Bound());
  t.On("c", "Protected").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("Protected");
  t.RunFor(Milliseconds(30));
  t.Crash("a");
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kDoneDegraded);
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Protected") << name;
}

TEST_F(Binding, SuspendsNothingWhereTheOtherIsUpAgainBeforeTheSwitchEnds) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").binds_to = {"a"};
  Harness& t = In("Active", config);
  t.On("c", "Protected").takes = Milliseconds(80);
  t.RequestSwitch("Protected");
  t.RunFor(Milliseconds(30));  // a and b are there
  t.Find("a", Health::kHung);
  t.Find("a", Health::kWell);
  t.Rest();
  EXPECT_THAT(t.records, Contains(Is(texts::ActuatorRecovered("a", "as the test says"))));
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kActuatorSuspended))));
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kDependencySuspended))));
}

TEST_F(Binding, HoldsAtAStartToo) {
  MachineConfig config = Bound();
  ActuatorNamed(config, "b").after = {};
  Harness t(config);
  t.On("a", "SelfCheck").code = 3009;
  t.Begin();
  t.Rest();
  EXPECT_TRUE(t.usable());
  EXPECT_NE(t.StateOf("b"), "Active");
  EXPECT_THAT(t.RecordOf("b").fault, Is(texts::NotUp("a")));
}

using BoundPair = OneController;

TEST_F(BoundPair, NoActuatorIsSuspendedBecauseOfItself) {
  config_.actuators[0].binds_to = {"b"};
  config_.actuators[1].binds_to = {"a"};
  StartUp();
  Of(0).restart.given_up = true;
  Do(event::TimePassed{});
  EXPECT_FALSE(Of(0).suspended);
  EXPECT_TRUE(Of(1).suspended);
}

TEST_F(Binding, ToTwoThatAreBoundToEachOtherEndsWhenBothAreUp) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "a").binds_to = {"b"};
  ActuatorNamed(config, "b").binds_to = {"c"};
  ActuatorNamed(config, "c").binds_to = {"b"};
  Harness& t = In("Active", config);
  t.Crash("b");
  t.Rest();
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Active") << name;
  EXPECT_THAT(Degraded(t.config(), t.machine()), ElementsAre());
}

// c is reached again before b is down.
TEST_F(Binding, HoldsWhileTheOtherIsStillOnItsWayDown) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "a").binds_to = {"b"};
  ActuatorNamed(config, "b").binds_to = {"c"};
  Harness& t = In("Active", config);
  t.On("b", "DeActive").takes = Milliseconds(60);
  t.Find("c", Health::kPartitioned, true);
  t.RunFor(Milliseconds(30));
  t.Find("c", Health::kWell);
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("a:DeActive", "b:DeActive", "b:Active", "a:Active"));
}

}  // namespace musher::testing::binding_test
