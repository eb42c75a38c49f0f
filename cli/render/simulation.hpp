#pragma once
// The report of `musher simulate`, as text and as JSON.

#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/search.hpp"

namespace musher::cli {

struct SimulationReport {
  const MachineConfig& config;
  std::string file;
  simulation::ScenarioOptions options;
  simulation::Summary summary;
  unsigned threads = 1;
  Duration took{};
  std::optional<simulation::ScenarioId> worst;  // the shortest failing scenario
  std::vector<std::string> others;              // actuators that use another protocol
  std::string rules;                            // file of --rules; empty: not given

  // Whether there is a file with rules of the user.
  bool has_rules() const { return !rules.empty() || !config.rules_file.empty(); }
};

// `failing_scenario`: the timeline of `worst`; empty when there is none.
std::string SimulationText(const SimulationReport& report, const std::string& failing_scenario,
                           bool colour);
std::string SimulationJson(const SimulationReport& report, const std::string& failing_scenario);

std::string ScenarioVerdict(const simulation::ScenarioEnd& ending);
std::string ScenarioJson(const simulation::ScenarioId& id, const simulation::ScenarioEnd& ending,
                         const std::string& text);

}  // namespace musher::cli
