// False positives that the checker must not report.

#include <gtest/gtest.h>

#include <utility>

#include "musher/simulation/fault_test.hpp"
#include "musher/simulation/scenario.hpp"

namespace musher::testing::checker_test {

using simulation::Injection;
using simulation::InjectionKind;

Injection At(Duration at, InjectionKind kind, const State& state = {}) {
  Injection injection;
  injection.at = at;
  injection.kind = kind;
  injection.actuator = 1;
  injection.state = state;
  injection.lasts = Milliseconds(100);
  return injection;
}

// A second controller begins at the same instant at which a deadline of the first one passes.
// Either may run first.
TEST(Checker, AcceptsADeadlineThatIsHandledLaterInTheSameInstant) {
  const auto config = simulation::ConfigAround("arm", {"SetUp", "SelfCheck", "Active", "LowPower"});
  ASSERT_TRUE(config) << config.error().message;
  simulation::ScenarioOptions options = simulation::UsualOptions(config.value());
  options.provided = false;
  const auto ending = RunScenario(config.value(), 1,
                                  {At(Milliseconds(2000), InjectionKind::kHang),
                                   At(Milliseconds(2000), InjectionKind::kSet, "LowPower"),
                                   At(Milliseconds(5000), InjectionKind::kTakeover),
                                   At(Milliseconds(5000), InjectionKind::kSet, "LowPower")},
                                  options);
  EXPECT_FALSE(ending.violation) << ending.violation->what;
}

// A robot of three actuators, with a policy for the battery.
MachineConfig ThreeActuators() {
  auto config = simulation::ConfigAround(
      "arm", {"SetUp", "SelfCheck", "Active", "Protected", "LowPower", "Error", "TearDown"});
  MachineConfig made = std::move(config).value();
  made.policy.emplace().battery.emplace();
  made.policy->low_power.emplace().motion_ids = {0, 101};
  return made;
}

// The violation in a run with these injected events; empty: none.
std::string ViolationOf(const MachineConfig& config, const simulation::Injections& injections,
                        std::uint64_t seed = 1) {
  simulation::ScenarioOptions options = simulation::UsualOptions(config);
  options.provided = false;
  options.shared_processes = true;
  const auto ending = RunScenario(config, seed, injections, options);
  return ending.violation ? ending.violation->what : "";
}

// The wake-up leads to Protected; the switch to Active begins in the step that reaches it.
TEST(Checker, AcceptsASwitchToActiveWhenTheCeilingEndsDuringAWakeUp) {
  const MachineConfig config = ThreeActuators();
  Injection low = At(Milliseconds(2000), InjectionKind::kBattery);
  low.random = 10 * 2 + 1;  // percent, and charging
  Injection full = At(Milliseconds(5000), InjectionKind::kBattery);
  full.random = 100 * 2 + 1;
  EXPECT_EQ(ViolationOf(config, {low, At(Milliseconds(2000), InjectionKind::kSet, "LowPower"),
                                 At(Milliseconds(5000), InjectionKind::kWakeUp), full}),
            "");
}

// The command to Error waits behind the one to Protected at an actuator that is frozen and hung.
TEST(Checker, AcceptsAFencedCommandThatWasGivenUpAsLost) {
  const MachineConfig config = [] {
    MachineConfig made = ThreeActuators();
    made.actuators[2].checkpoint = Milliseconds(200);
    made.actuators[2].command.clear();  // not the controller's to kill
    return made;
  }();
  Injection stopped = At(Milliseconds(5000), InjectionKind::kFreeze);
  stopped.lasts = Milliseconds(500);
  stopped.actuator = 2;
  EXPECT_EQ(ViolationOf(config, {stopped, At(Milliseconds(5000), InjectionKind::kSet, "Protected"),
                                 At(Milliseconds(5000), InjectionKind::kSet, "Error")}),
            "");
}

// The takeover was requested first, and waits for the frozen controller.
TEST(Checker, AcceptsATakeoverThatStartsAMachineTornDownWhileItWaited) {
  Injection tear_down = At(Milliseconds(5000), InjectionKind::kClientSet, "TearDown");
  tear_down.random = 1;  // of the machine
  EXPECT_EQ(
      ViolationOf(ThreeActuators(), {At(Milliseconds(5000), InjectionKind::kControllerFreeze),
                                     tear_down, At(Milliseconds(5000), InjectionKind::kTakeover)}),
      "");
}

// Its process stays with the other actuator, so only a restart makes it available again.
TEST(Checker, AcceptsARestartOfAnActuatorTornDownAloneInASharedProcess) {
  MachineConfig config = ThreeActuators();
  config.actuators[1].command.clear();
  std::uint64_t seed = 1;
  while (simulation::SampleLayout(config, seed, true).ProcessOf(1) == 1) ++seed;
  EXPECT_EQ(ViolationOf(config, {At(Milliseconds(5000), InjectionKind::kSetOne, "TearDown")}, seed),
            "");
}

// The raise at 100 % is undone, and retried at 21 %: below the hysteresis, but the ceiling was left
// at 100 % and begins at 20 %.
TEST(Checker, AcceptsARetriedRaiseAfterTheCeilingWasLeft) {
  Injection low = At(Milliseconds(3000), InjectionKind::kBattery);
  low.random = 10 * 2;  // percent, and not charging
  Injection fails = At(Milliseconds(6000), InjectionKind::kFail);
  fails.lasts = Milliseconds(50);  // the way back succeeds
  Injection full = At(Milliseconds(6000), InjectionKind::kBattery);
  full.random = 100 * 2;
  Injection lower = At(Milliseconds(6500), InjectionKind::kBattery);
  lower.random = 21 * 2;
  EXPECT_EQ(ViolationOf(ThreeActuators(), {low, fails, full, lower}), "");
}

}  // namespace musher::testing::checker_test
