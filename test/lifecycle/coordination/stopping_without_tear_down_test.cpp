// Actuators that do not list TearDown: the machine is stopped all the same.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::stopping_without_tear_down_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

MachineConfig WithoutTearDown(bool with_command) {
  MachineConfig config = MachineOf(2);
  for (ActuatorConfig& actuator : config.actuators) {
    std::erase(actuator.states, State(kTearDown));
    actuator.times.assign(actuator.states.size(), Milliseconds(100));
    if (with_command) actuator.command = {"run", actuator.name};
  }
  config.shutdown_budget = Milliseconds(2000);
  return config;
}

TEST(StoppingWithoutTearDown, ActuatorsThatDoNotListItGetSigtermAndSigkillWithinTheBudget) {
  Harness t(WithoutTearDown(true));
  t.Begin();
  t.Rest();
  t.On("b", "TERM").hangs = true;
  const Time begun = t.now();
  const SwitchResult result = t.Set("TearDown");
  EXPECT_TRUE(result.done()) << result.reason;
  EXPECT_TRUE(t.stopped());
  EXPECT_LE(t.now() - begun, Milliseconds(2000));
  EXPECT_THAT(t.signals, ElementsAre("a:TERM", "b:TERM", "b:KILL"));
}

TEST(StoppingWithoutTearDown, AnActuatorThatNothingEndsIsListed) {
  Harness t(WithoutTearDown(false));
  t.Begin();
  t.Rest();
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.degraded, ElementsAre("a", "b"));
  EXPECT_THAT(result.reason, HasSubstr(texts::KeepsRunning("Active").message));
  EXPECT_TRUE(t.stopped());
}

}  // namespace musher::testing::stopping_without_tear_down_test
