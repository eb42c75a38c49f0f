// The order of TearDown, and how its time is shared.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::stopping_order_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

MachineConfig TwoStages() {
  MachineConfig config = MachineOf(3);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  ActuatorNamed(config, "c").stage = 2;
  config.shutdown_budget = Milliseconds(1000);
  return config;
}

TEST(StoppingByStages, TheLastStageIsTornDownBeforeTheFirst) {
  Harness t(TwoStages());
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.StateOf("c"), "Active");
  t.On("c", "TearDown").takes = Milliseconds(80);
  t.ClearLog();
  t.RequestSwitch("TearDown");
  t.RunFor(Milliseconds(60));
  EXPECT_THAT(t.log(), ElementsAre("c:TearDown")) << "stage 1 is what stage 2 stands on";
  t.Rest();
  EXPECT_THAT(t.log(), ElementsAre("c:TearDown", "a:TearDown", "b:TearDown"));
  EXPECT_TRUE(t.stopped());
}

TEST(StoppingByStages, AStageThatHangsDoesNotTakeTheTimeOfTheOnesBeforeIt) {
  MachineConfig config = TwoStages();
  for (ActuatorConfig& actuator : config.actuators) actuator.times.assign(9, Milliseconds(5000));
  Harness t(config);
  t.Begin();
  t.Rest();
  t.On("c", "TearDown").hangs = true;
  t.On("a", "TearDown").takes = Milliseconds(250);
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kDone) << result.actuators[0].message;
  EXPECT_TRUE(t.stopped());
}

// c is torn down before a, in the same stage.
MachineConfig HangingBefore() {
  MachineConfig config = MachineOf(3);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.command = {"run", actuator.name};
    actuator.times.assign(9, Milliseconds(8000));
  }
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "c").after = {"a"};
  return config;
}

TEST(StoppingInOrder, AnActuatorThatHangsLeavesTimeForTheOneThatItStandsOn) {
  Harness t(HangingBefore());
  t.Begin();
  t.Rest();
  t.On("c", "TearDown").hangs = true;
  t.On("a", "TearDown").takes = Milliseconds(3000);
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kDone) << result.actuators[0].message;
  EXPECT_TRUE(t.stopped());
}

TEST(StoppingInOrder, AnActuatorHasAllOfItsTimeWhereTheTimesFit) {
  MachineConfig config = HangingBefore();
  ActuatorNamed(config, "a").times.assign(9, Milliseconds(500));
  ActuatorNamed(config, "c").times.assign(9, Milliseconds(6000));
  Harness t(config);
  t.Begin();
  t.Rest();
  t.On("c", "TearDown").takes = Milliseconds(5900);
  EXPECT_TRUE(t.Set("TearDown").done());
}

TEST(StoppingInOrder, AnActuatorForWhichNoTimeIsLeftIsNotCommanded) {
  MachineConfig config = HangingBefore();
  config.shutdown_budget = Milliseconds(2000);
  Harness t(config);
  t.Begin();
  t.Rest();
  t.ClearLog();
  t.On("c", "TearDown").hangs = true;
  t.Mute("c", true, true);  // the queries for its outcome take what its share leaves
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kSkipped);
  EXPECT_EQ(result.actuators[0].message, texts::BudgetUsedUp().message);
  EXPECT_THAT(t.log(), ElementsAre("b:TearDown"));
}

TEST(StoppingByStages, AnActuatorWhoseTurnDoesNotComeWithinTheBudgetIsListedWithATimeout) {
  MachineConfig config = MachineOf(2);
  ActuatorNamed(config, "b").stage = 2;
  config.shutdown_budget = Milliseconds(800);
  Harness t(config);
  t.Begin();
  t.Rest();
  t.Mute("b", true, true);
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kSkipped);
  EXPECT_EQ(result.actuators[0].code, kCodeTimeout);
}

}  // namespace musher::testing::stopping_order_test
