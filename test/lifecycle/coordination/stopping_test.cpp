#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/theatre.hpp"

namespace musher::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

class Stopping : public ::testing::Test {
 protected:
  static MachineConfig Chain() {
    MachineConfig config = MachineOf(3);
    for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
    ActuatorNamed(config, "a").after = {"b"};
    ActuatorNamed(config, "b").after = {"c"};
    config.shutdown_budget = Milliseconds(2000);
    return config;
  }
  Stopping() : t(Chain()) {
    t.Begin();
    t.Rest();
    EXPECT_EQ(t.machine().state, "Active");
    t.ClearLog();
  }
  Theatre t;
};

TEST_F(Stopping, TearsDownInReverseOrderAndTheProcessesEndByThemselves) {
  EXPECT_TRUE(t.Set("TearDown").done());
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown", "c:TearDown"));
  EXPECT_TRUE(t.stopped());
  EXPECT_EQ(t.machine().phase, Phase::kStopped);
  EXPECT_THAT(t.signals, ElementsAre());
}

TEST_F(Stopping, OneThatFailsToTearDownGetsSigtermAndDoesNotKeepTheOthers) {
  t.On("b", "TearDown").code = 5001;
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(t.log(), ElementsAre("a:TearDown", "b:TearDown", "c:TearDown"));
  EXPECT_THAT(t.signals, ElementsAre("b:TERM"));
  EXPECT_TRUE(t.stopped());
}

TEST_F(Stopping, OneThatHangsAndIgnoresSigtermIsKilledWithinTheBudget) {
  t.On("b", "TearDown").hangs = true;
  t.On("b", "TERM").hangs = true;
  const Time begun = t.now();
  t.Set("TearDown");
  EXPECT_THAT(t.signals, ElementsAre("b:TERM", "b:KILL"));
  EXPECT_TRUE(t.stopped());
  EXPECT_LE(t.now() - begun, Milliseconds(2000));
}

TEST_F(Stopping, TheWholeNeverExceedsTheBudgetThoughEverybodyHangs) {
  for (const char* name : {"a", "b", "c"}) {
    t.On(name, "TearDown").hangs = true;
    t.On(name, "TERM").hangs = true;
  }
  const Time begun = t.now();
  t.Set("TearDown");
  EXPECT_TRUE(t.stopped());
  EXPECT_LE(t.now() - begun, Milliseconds(2000));
  EXPECT_THAT(t.signals, ::testing::IsSupersetOf({"a:KILL", "b:KILL", "c:KILL"}));
}

TEST_F(Stopping, SupersedesASwitchUnderWay) {
  t.On("b", "LowPower").takes = Milliseconds(80);
  const RequestId first = t.Ask("LowPower");
  t.RunFor(Milliseconds(30));
  EXPECT_TRUE(t.Set("TearDown").done());
  EXPECT_EQ(t.answers.at(first).outcome, SwitchOutcome::kSuperseded);
}

TEST_F(Stopping, AskedForTwiceIsOneStop) {
  const RequestId first = t.Ask("TearDown");
  const RequestId second = t.Ask("TearDown");
  t.Rest();
  EXPECT_TRUE(t.answers.at(first).done());
  EXPECT_TRUE(t.answers.at(second).done());
}

TEST_F(Stopping, RefusesEverythingElseFromThenOn) {
  t.Set("TearDown");
  EXPECT_EQ(t.Set("Active").outcome, SwitchOutcome::kRefused);
}

TEST(StoppingEarly, EndsProcessesThatAreStillSettingUp) {
  MachineConfig config = MachineOf(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
  ActuatorNamed(config, "b").times.assign(9, Milliseconds(60'000));
  Theatre t(config);
  t.On("b", "SetUp").hangs = true;
  t.Begin();
  t.RunFor(Milliseconds(500));
  EXPECT_TRUE(t.Set("TearDown").done()) << "what never was there is not left behind";
  EXPECT_TRUE(t.stopped());
  EXPECT_THAT(t.signals, UnorderedElementsAre("b:TERM"));
}

}  // namespace
}  // namespace musher::testing
