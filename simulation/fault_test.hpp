#pragma once
// Runs an actuator class in many scenarios and shrinks the first one that fails. The part of
// actuator_fault_test.hpp (which users include) that needs no template.
//
// Threads: one, and those of the callbacks (module_under_test.hpp).

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/module_under_test.hpp"
#include "musher/simulation/search.hpp"

namespace musher::simulation {

// A scenario that failed.
struct FaultTestFailure {
  ScenarioId id;     // shrunk
  std::string what;  // a sentence
  std::string timeline;
  bool reproduced = true;  // it failed again when it was replayed
};

class FaultTest {
 public:
  // `setup.check` and `setup.check_stop` need not report failures themselves: `next_failure` is
  // called after each of them, and returns the next failure of the test; empty: there is none.
  FaultTest(MachineConfig config, ActuatorIndex actuator, ModuleUnderTest::Setup setup,
            std::function<std::string()> next_failure, std::function<void()> before_scenario);

  // Runs `count` scenarios from the seed `first` on; returns the first failing one, shrunk.
  std::optional<FaultTestFailure> Find(std::uint64_t first, std::uint64_t count);
  // Runs one scenario; nothing: it passed. Fails when it has no injected event of that number.
  Result<std::optional<FaultTestFailure>> Run(const ScenarioId& id);
  // Timeline of the last scenario, as text.
  const std::string& timeline() const { return timeline_; }
  const FaultTestCounts& counts() const { return counts_; }

 private:
  struct Verdict {
    std::string what;
    std::optional<Invariant> invariant;  // that is violated; nullopt: the module's check failed
  };
  std::optional<Verdict> RunOnce(const ScenarioId& id);
  FaultTestFailure Shorten(std::uint64_t seed, const Verdict& verdict);

  const MachineConfig config_;
  const ActuatorIndex actuator_;
  const ScenarioOptions options_;
  ModuleUnderTest::Setup setup_;
  const std::function<std::string()> next_failure_;
  const std::function<void()> before_scenario_;
  std::function<void(const std::string&)> on_failure_;  // of the running scenario
  bool stuck_ = false;                                  // a thread was given up
  std::string timeline_;
  FaultTestCounts counts_;
};

// The injected events for a robot whose actuator is under test: as SampleInjections(), but half of
// them hit that actuator. In addition the machine switches down and up once, and one event hits the
// actuator during that.
Injections SampleInjectionsAt(const MachineConfig& config, ActuatorIndex actuator,
                              std::uint64_t seed);

// A robot of an actuator with these states and two neighbours, one before and one after it. Fails
// for a state whose rank only a config can give.
Result<MachineConfig> ConfigAround(const std::string& actuator, const std::vector<State>& states);

// "MUSHER_SEED=42 MUSHER_ONLY=3,7 ./gripper_test --gtest_filter=Gripper.HoldsItsLoad"
std::string ReplayCommand(const ScenarioId& id, const std::string& test);
// MUSHER_SEED and MUSHER_ONLY of the environment; nothing without MUSHER_SEED.
Result<std::optional<ScenarioId>> ScenarioFromEnvironment();

}  // namespace musher::simulation
