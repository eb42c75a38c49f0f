#pragma once
// An actuator class in many stories; the first that ends badly is told in short. What
// actuator_trial.hpp, which users have, is made of.
//
// Threads: one, and those of the callbacks (rehearsed_module.hpp).

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/rehearsed_module.hpp"
#include "musher/simulation/search.hpp"

namespace musher::simulation {

// A story that ended badly.
struct TrialFailure {
  StoryId id;        // shrunk
  std::string what;  // a sentence
  std::string timeline;
  bool again = true;  // it ended badly when it was told again
};

class Trial {
 public:
  // `production.judge` and the like need not complain themselves: `complaint` is asked after each;
  // empty: nothing is wrong.
  Trial(MachineConfig config, std::size_t actuator, RehearsedModule::Production production,
        std::function<std::string()> complaint, std::function<void()> before_story);

  // Tells so many stories, from that seed on; gives the first bad one.
  std::optional<TrialFailure> Find(std::uint64_t first, std::uint64_t count);
  // Tells one. Fails when there is no such incident; nothing: it ended well.
  Result<std::optional<TrialFailure>> Tell(const StoryId& id);
  // What the last story told, as text.
  const std::string& timeline() const { return timeline_; }
  const TrialTally& tally() const { return tally_; }

 private:
  struct Verdict {
    std::string what;
    std::optional<Promise> promise;  // of the machine's; else it is the module's own fault
  };
  std::optional<Verdict> TellOnce(const StoryId& id);
  TrialFailure Shorten(std::uint64_t seed, const Verdict& verdict);

  const MachineConfig config_;
  const std::size_t actuator_;
  const StoryOptions options_;
  RehearsedModule::Production production_;
  const std::function<std::string()> complaint_;
  const std::function<void()> before_story_;
  std::function<void(const std::string&)> on_complaint_;  // in the story that is told
  bool stuck_ = false;                                    // a thread was given up
  std::string timeline_;
  TrialTally tally_;
};

// What befalls a robot whose actuator is under trial: as DrawIncidents() has it, but aimed at that
// one half of the time; and once something happens to it in the midst of a way down and up again.
Incidents DrawIncidentsAt(const MachineConfig& config, std::size_t actuator, std::uint64_t seed);

// A robot of an actuator with these states and two neighbours, one before and one after it. Fails
// for a state that only a config can explain.
Result<MachineConfig> ConfigAround(const std::string& actuator, const std::vector<State>& states);

// "MUSHER_SEED=42 MUSHER_ONLY=3,7 ./gripper_test --gtest_filter=Gripper.KeepsItsWord"
std::string TrialCommand(const StoryId& id, const std::string& test);
// MUSHER_SEED and MUSHER_ONLY of the environment; nothing when there is no such seed.
Result<std::optional<StoryId>> StoryFromEnvironment();

}  // namespace musher::simulation
