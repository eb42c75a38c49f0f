#pragma once
// An actuator class in many scenarios; the first that ends badly is told in short. What
// actuator_fault_test.hpp, which users have, is made of.
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

// A scenario that ended badly.
struct FaultTestFailure {
  ScenarioId id;     // shrunk
  std::string what;  // a sentence
  std::string timeline;
  bool again = true;  // it ended badly when it was told again
};

class FaultTest {
 public:
  // `production.judge` and the like need not complain themselves: `complaint` is asked after each;
  // empty: nothing is wrong.
  FaultTest(MachineConfig config, std::size_t actuator, ModuleUnderTest::Production production,
            std::function<std::string()> complaint, std::function<void()> before_scenario);

  // Tells so many scenarios, from that seed on; gives the first bad one.
  std::optional<FaultTestFailure> Find(std::uint64_t first, std::uint64_t count);
  // Tells one. Fails when there is no such injected event; nothing: it ended well.
  Result<std::optional<FaultTestFailure>> Tell(const ScenarioId& id);
  // What the last scenario told, as text.
  const std::string& timeline() const { return timeline_; }
  const FaultTestCounts& tally() const { return tally_; }

 private:
  struct Verdict {
    std::string what;
    std::optional<Invariant> invariant;  // of the machine's; else it is the module's own fault
  };
  std::optional<Verdict> TellOnce(const ScenarioId& id);
  FaultTestFailure Shorten(std::uint64_t seed, const Verdict& verdict);

  const MachineConfig config_;
  const std::size_t actuator_;
  const ScenarioOptions options_;
  ModuleUnderTest::Production production_;
  const std::function<std::string()> complaint_;
  const std::function<void()> before_scenario_;
  std::function<void(const std::string&)> on_complaint_;  // in the scenario that is told
  bool stuck_ = false;                                    // a thread was given up
  std::string timeline_;
  FaultTestCounts tally_;
};

// What befalls a robot whose actuator is under trial: as SampleInjections() has it, but aimed at
// that one half of the time; and once something happens to it in the midst of a way down and up
// again.
Injections SampleInjectionsAt(const MachineConfig& config, std::size_t actuator,
                              std::uint64_t seed);

// A robot of an actuator with these states and two neighbours, one before and one after it. Fails
// for a state that only a config can explain.
Result<MachineConfig> ConfigAround(const std::string& actuator, const std::vector<State>& states);

// "MUSHER_SEED=42 MUSHER_ONLY=3,7 ./gripper_test --gtest_filter=Gripper.KeepsItsWord"
std::string TrialCommand(const ScenarioId& id, const std::string& test);
// MUSHER_SEED and MUSHER_ONLY of the environment; nothing when there is no such seed.
Result<std::optional<ScenarioId>> ScenarioFromEnvironment();

}  // namespace musher::simulation
