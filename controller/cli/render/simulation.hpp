#pragma once
// What `musher simulate` found, for people and as JSON.

#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/search.hpp"

namespace musher::cli {

struct SimulationReport {
  const MachineConfig& config;
  std::string file;
  simulation::StoryOptions options;
  simulation::Summary summary;
  unsigned threads = 1;
  Duration took{};
  std::optional<simulation::StoryId> worst;  // the shortest bad story
  std::vector<std::string> others;           // actuators that speak another protocol
};

// `bad_story`: the timeline of the worst; empty when there is none.
std::string SimulationText(const SimulationReport& report, const std::string& bad_story,
                           bool colour);
std::string SimulationJson(const SimulationReport& report, const std::string& bad_story);

inline double Seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

std::string StoryVerdict(const simulation::Ending& ending);
std::string StoryJson(const simulation::StoryId& id, const simulation::Ending& ending,
                      const std::string& text);

}  // namespace musher::cli
