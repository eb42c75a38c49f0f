// Robots drawn from seeds, what befalls them drawn from the same seeds, and every promise judged
// after every event. MUSHER_SEED=n lives one life and tells it, MUSHER_SEEDS=n lives that many.

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "musher/simulation/story.hpp"
#include "musher/simulation/timeline.hpp"
#include "musher/test/simulation/drawn_config.hpp"

namespace musher::testing {
namespace {

std::uint64_t Environment(const char* name, std::uint64_t otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : std::strtoull(value, nullptr, 10);
}

TEST(Stories, KeepEveryPromise) {
  const std::uint64_t only = Environment("MUSHER_SEED", 0);
  const std::uint64_t last = only != 0 ? only : Environment("MUSHER_SEEDS", 1000);
  simulation::Coverage coverage;
  std::map<std::string, std::vector<std::uint64_t>> bad;
  for (std::uint64_t seed = only != 0 ? only : 1; seed <= last; ++seed) {
    const MachineConfig config = DrawConfig(seed);
    simulation::StoryOptions options = simulation::UsualOptions(config);
    options.provided = false;
    simulation::Story story(config, seed, simulation::DrawIncidents(config, seed), options);
    std::optional<simulation::Timeline> timeline;
    if (only != 0) timeline.emplace(story, config);
    const auto ending = story.Tell();
    if (timeline) {
      timeline->End(ending);
      std::cout << timeline->Text();
      for (std::size_t i = 0; i < config.actuators.size() && story.robot().has_controller(); ++i) {
        const ActuatorRecord& r = story.robot().machine().actuators[i];
        std::cout << config.actuators[i].name << " after " << (config.actuators[i].after.empty() ? "" : config.actuators[i].after[0]) << " binds " << (config.actuators[i].binds_to.empty() ? "" : config.actuators[i].binds_to[0])<< " stage " << config.actuators[i].stage
                  << ": " << PresenceName(r.presence) << " " << r.state() << " busy " << r.report.target << " checked " << r.checked << " due " << r.due << " held " << r.held << " parked " << r.parked << " tried " << r.join_tried << " cmd " << config.actuators[i].command.size()
                  << " fault " << (r.fault ? r.fault->message : "") << "\n";
      }
    }
    coverage.Add(ending.coverage);
    if (ending.violation) {
      auto& list = bad[std::string(PromiseText(ending.violation->promise))];
      list.push_back(seed);
      if (list.size() <= 3)
        std::cout << seed << " at " << ToMilliseconds(ending.violation->at) << ": "
                  << ending.violation->what << "\n";
    }
  }
  for (auto& [what, seeds] : bad) std::cout << what << " " << seeds.size() << "\n";
  std::cout << coverage.Text();
}

}  // namespace
}  // namespace musher::testing
