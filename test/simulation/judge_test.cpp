// What the judge must not say.

#include <gtest/gtest.h>

#include <utility>

#include "musher/simulation/story.hpp"
#include "musher/simulation/trial.hpp"

namespace musher::testing::judge_test {

using simulation::Incident;
using simulation::IncidentKind;

Incident At(Duration at, IncidentKind kind, const State& state = {}) {
  Incident incident;
  incident.at = at;
  incident.kind = kind;
  incident.actuator = 1;
  incident.state = state;
  incident.lasts = Milliseconds(100);
  return incident;
}

// A second controller begins at the very instant at which the first one's patience ends: whose turn
// comes first is no fault of the other's.
TEST(Judge, LetsAControllerHaveItsTurnAtTheInstantOfItsDeadline) {
  const auto config = simulation::ConfigAround("arm", {"SetUp", "SelfCheck", "Active", "LowPower"});
  ASSERT_TRUE(config) << config.error().message;
  simulation::StoryOptions options = simulation::UsualOptions(config.value());
  options.provided = false;
  const auto ending = TellStory(config.value(), 1,
                                {At(Milliseconds(2000), IncidentKind::kHang),
                                 At(Milliseconds(2000), IncidentKind::kSet, "LowPower"),
                                 At(Milliseconds(5000), IncidentKind::kTakeover),
                                 At(Milliseconds(5000), IncidentKind::kSet, "LowPower")},
                                options);
  EXPECT_FALSE(ending.violation) << ending.violation->what;
}

// A robot of three actuators, with a policy for the battery.
MachineConfig ThreeActuators() {
  auto config = simulation::ConfigAround(
      "arm", {"SetUp", "SelfCheck", "Active", "Protected", "LowPower", "Error", "TearDown"});
  MachineConfig made = std::move(config).value();
  made.policy.emplace().battery.emplace();
  made.policy->low_power.emplace();
  return made;
}

// What the judge says against a run with these incidents; empty: nothing.
std::string Against(const MachineConfig& config, const simulation::Incidents& incidents,
                    std::uint64_t seed = 1) {
  simulation::StoryOptions options = simulation::UsualOptions(config);
  options.provided = false;
  options.shared_processes = true;
  const auto ending = TellStory(config, seed, incidents, options);
  return ending.violation ? ending.violation->what : "";
}

// The wake-up leads to Protected, and Active begins in the very step in which that is reached.
TEST(Judge, LetsTheMachineGoOnToActiveWhenItsCeilingGoesDuringAWakeUp) {
  const MachineConfig config = ThreeActuators();
  Incident low = At(Milliseconds(2000), IncidentKind::kBattery);
  low.chance = 10 * 2 + 1;  // percent, and charging
  Incident full = At(Milliseconds(5000), IncidentKind::kBattery);
  full.chance = 100 * 2 + 1;
  EXPECT_EQ(Against(config, {low, At(Milliseconds(2000), IncidentKind::kSet, "LowPower"),
                             At(Milliseconds(5000), IncidentKind::kWakeUp), full}),
            "");
}

// The command to Error waits behind that to Protected at an actuator that is stopped, and hung.
TEST(Judge, LetsACommandBeFencedThatWasGivenUpAsLost) {
  const MachineConfig config = [] {
    MachineConfig made = ThreeActuators();
    made.actuators[2].checkpoint = Milliseconds(200);
    made.actuators[2].command.clear();  // not ours to kill
    return made;
  }();
  Incident stopped = At(Milliseconds(5000), IncidentKind::kFreeze);
  stopped.lasts = Milliseconds(500);
  stopped.actuator = 2;
  EXPECT_EQ(Against(config, {stopped, At(Milliseconds(5000), IncidentKind::kSet, "Protected"),
                             At(Milliseconds(5000), IncidentKind::kSet, "Error")}),
            "");
}

// The takeover was asked for first, and waits for the controller that is stopped.
TEST(Judge, LetsATakeoverStartTheMachineThatWasTornDownWhileItWaited) {
  Incident tear_down = At(Milliseconds(5000), IncidentKind::kClientSet, "TearDown");
  tear_down.chance = 1;  // of the machine
  EXPECT_EQ(Against(ThreeActuators(), {At(Milliseconds(5000), IncidentKind::kControllerFreeze),
                                       tear_down, At(Milliseconds(5000), IncidentKind::kTakeover)}),
            "");
}

// Its process lives on with the other actuator, so that nothing but a restart brings it back.
TEST(Judge, LetsPeopleRestartWhatWasTornDownAloneInAProcessThatItShares) {
  MachineConfig config = ThreeActuators();
  config.actuators[1].command.clear();
  std::uint64_t seed = 1;
  while (simulation::DrawLayout(config, seed, true).ProcessOf(1) == 1) ++seed;
  EXPECT_EQ(Against(config, {At(Milliseconds(5000), IncidentKind::kSetOne, "TearDown")}, seed), "");
}

// The raise at 100 % is undone, and tried again at 21 %: below the hysteresis, but the ceiling was
// left at 100 % and begins at 20 %.
TEST(Judge, LetsARaiseBeTriedAgainWhereTheCeilingWasLeftBefore) {
  Incident low = At(Milliseconds(3000), IncidentKind::kBattery);
  low.chance = 10 * 2;  // percent, and no cable
  Incident fails = At(Milliseconds(6000), IncidentKind::kFail);
  fails.lasts = Milliseconds(50);  // the way back succeeds
  Incident full = At(Milliseconds(6000), IncidentKind::kBattery);
  full.chance = 100 * 2;
  Incident lower = At(Milliseconds(6500), IncidentKind::kBattery);
  lower.chance = 21 * 2;
  EXPECT_EQ(Against(ThreeActuators(), {low, fails, full, lower}), "");
}

}  // namespace musher::testing::judge_test
