#pragma once
// Many stories of one config, and the shortest bad one.
//
// Threads: LiveMany() uses several; the rest one.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/story.hpp"

namespace musher::simulation {

// Which story: the one that a seed draws, or some of its incidents, by their number from 1.
struct StoryId {
  std::uint64_t seed = 0;
  std::optional<std::vector<std::size_t>> only;
};

// The incidents of a story. Fails when there is no incident of a number.
Result<Incidents> IncidentsOf(const MachineConfig& config, const StoryId& id);

// What many stories had in common.
struct Summary {
  std::uint64_t stories = 0;
  Coverage coverage;
  std::array<std::uint64_t, 5> switches{};  // by SwitchOutcome
  std::uint64_t judgements = 0;
  std::uint64_t steps = 0;
  Duration simulated{};
  std::vector<Duration> rests;  // how long after the last fault, ascending
  std::array<std::vector<std::uint64_t>, kPromises> bad;  // seeds, ascending, by promise

  bool good() const;
  void Add(std::uint64_t seed, const Ending& ending);
  // To be called when all are added.
  void Sort();
};

// Lives the stories of the seeds from `first` on, on `threads` threads. `on_done` is told how many
// are over, now and then; it may say false to end early. The summary is the same however many
// threads there are.
Summary LiveMany(const MachineConfig& config, const StoryOptions& options, std::uint64_t first,
                 std::uint64_t count, unsigned threads,
                 const std::function<bool(std::uint64_t)>& on_done);

// Of the incidents 1 to `count` as few as can be that are `bad` still. All of them are.
std::vector<std::size_t> ShrinkWhile(
    std::size_t count, const std::function<bool(const std::vector<std::size_t>&)>& bad);

// The same promise broken by as few incidents as can be.
StoryId Shrink(const MachineConfig& config, const StoryOptions& options, std::uint64_t seed,
               Promise promise);

// Of the bad ones of a summary: those that break a promise are shrunk, some of them, and that with
// the fewest incidents is taken. nullopt: none is bad.
std::optional<StoryId> ShortestBadStory(const MachineConfig& config, const StoryOptions& options,
                                        const Summary& summary);

}  // namespace musher::simulation
