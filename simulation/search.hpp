#pragma once
// Runs many scenarios of one config, and shrinks the failing ones.
//
// Threads: RunMany() uses several; the rest one.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/scenario.hpp"
#include "musher/simulation/scenario_id.hpp"

namespace musher::simulation {

// The injected events of a scenario. Fails for a number that the seed has no event for.
Result<Injections> InjectionsOf(const MachineConfig& config, const ScenarioId& id);

// The results of many scenarios.
struct Summary {
  std::uint64_t scenarios = 0;
  Coverage coverage;
  std::array<std::uint64_t, 5> switches{};  // by SwitchOutcome
  std::uint64_t checks = 0;
  std::uint64_t steps = 0;
  Duration simulated{};
  std::vector<Duration> rests;                              // ScenarioEnd::rested, ascending
  std::array<std::vector<std::uint64_t>, kInvariants> bad;  // seeds, ascending, by invariant
  UserRulesCoverage rule_coverage;

  bool good() const;
  void Add(std::uint64_t seed, const ScenarioEnd& ending);
  // Call when all are added.
  void Sort();
};

// Runs the scenarios of the seeds from `first` on, on `threads` threads. `on_done` is called now
// and then with how many are done; it returns false to end early. The summary does not depend on
// the number of threads.
Summary RunMany(const MachineConfig& config, const ScenarioOptions& options, std::uint64_t first,
                std::uint64_t count, unsigned threads,
                const std::function<bool(std::uint64_t)>& on_done);

// Removes as many of the injected events 1 to `count` as possible while `bad` still holds. It must
// hold for all of them.
std::vector<std::size_t> ShrinkWhile(
    std::size_t count, const std::function<bool(const std::vector<std::size_t>&)>& bad);

// The scenario of the seed with as few injected events as violate the same invariant.
ScenarioId Shrink(const MachineConfig& config, const ScenarioOptions& options, std::uint64_t seed,
                  Invariant invariant);

// Shrinks some failing scenarios of each violated invariant, and returns the one with the fewest
// injected events. nullopt: none failed.
std::optional<ScenarioId> ShortestFailingScenario(const MachineConfig& config,
                                                  const ScenarioOptions& options,
                                                  const Summary& summary);

}  // namespace musher::simulation
