#pragma once
// Many scenarios of one config, and the shortest bad one.
//
// Threads: LiveMany() uses several; the rest one.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/scenario.hpp"

namespace musher::simulation {

// Which scenario: the one that a seed draws, or some of its injected events, by their number
// from 1.
struct ScenarioId {
  std::uint64_t seed = 0;
  std::optional<std::vector<std::size_t>> only;
};

// The injected events of a scenario. Fails when there is no injected event of a number.
Result<Injections> InjectionsOf(const MachineConfig& config, const ScenarioId& id);

// What many scenarios had in common.
struct Summary {
  std::uint64_t scenarios = 0;
  Coverage coverage;
  std::array<std::uint64_t, 5> switches{};  // by SwitchOutcome
  std::uint64_t checks = 0;
  std::uint64_t steps = 0;
  Duration simulated{};
  std::vector<Duration> rests;  // how long after the last fault, ascending
  std::array<std::vector<std::uint64_t>, kInvariants> bad;  // seeds, ascending, by invariant

  bool good() const;
  void Add(std::uint64_t seed, const Ending& ending);
  // To be called when all are added.
  void Sort();
};

// Lives the scenarios of the seeds from `first` on, on `threads` threads. `on_done` is told how
// many are over, now and then; it may say false to end early. The summary is the same however many
// threads there are.
Summary LiveMany(const MachineConfig& config, const ScenarioOptions& options, std::uint64_t first,
                 std::uint64_t count, unsigned threads,
                 const std::function<bool(std::uint64_t)>& on_done);

// Of the injected events 1 to `count` as few as can be that are `bad` still. All of them are.
std::vector<std::size_t> ShrinkWhile(
    std::size_t count, const std::function<bool(const std::vector<std::size_t>&)>& bad);

// The same invariant broken by as few injected events as can be.
ScenarioId Shrink(const MachineConfig& config, const ScenarioOptions& options, std::uint64_t seed,
                  Invariant invariant);

// Of the bad ones of a summary: those that break a invariant are shrunk, some of them, and that
// with the fewest injected events is taken. nullopt: none is bad.
std::optional<ScenarioId> ShortestFailingScenario(const MachineConfig& config,
                                                  const ScenarioOptions& options,
                                                  const Summary& summary);

}  // namespace musher::simulation
