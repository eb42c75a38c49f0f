// musher-meilin: a match of the competition robot. See README.md in modules/meilin.

#include <string_view>

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/meilin/mission/meilin_actuator.hpp"
#include "musher/modules/meilin/mission/send_tool.hpp"
#include "musher/modules/meilin/mission/tree_tool.hpp"
#include "musher/modules/meilin/plan/tool.hpp"

namespace {

using musher::Parsed;
using musher::meilin::MatchConfig;
using musher::meilin::MatchReading;
using musher::meilin::MissionConfig;

int Run(const musher::program::Options& options) {
  const Parsed<MissionConfig> reading = musher::meilin::ReadMissionFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return musher::program::kUsageError;
  MatchConfig match;
  if (!reading.config->match_config.empty()) {
    const MatchReading read = musher::meilin::ReadMatchFile(reading.config->match_config);
    for (const std::string& error : read.errors) {
      musher::program::PrintErrors({{reading.config->match_config, 0, 0, musher::Severity::kError,
                                     "CONFIG_ERROR: " + error}});
    }
    if (!read.config) return musher::program::kUsageError;
    match = *read.config;
  }
  musher::meilin::MeilinActuator actuator(options.actuator, *reading.config, match);
  return musher::program::RunToEnd(actuator, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view command = argc > 1 ? argv[1] : "";
  if (command == "models") return musher::meilin::PrintModels(argc - 1, argv + 1);
  if (command == "start") return musher::meilin::StartTool(argc - 1, argv + 1);
  if (command == "send") return musher::meilin::Send(argc - 1, argv + 1);
  if (musher::meilin::IsPlanTool(command)) {
    return musher::meilin::RunPlanTool(argc - 1, argv + 1, musher::meilin::CheckTreeOrMatch);
  }
  return musher::program::Main(
      argc, argv,
      {"musher-meilin", "A match of the competition robot, as the actuator meilin.",
       "`musher-meilin start [full|meilin|final]` begins a match that waits; without a person's "
       "word\nnothing moves. `musher-meilin check FILE` reports the errors of a tree, a match "
       "config or a plan,\n"
       "`musher-meilin plan FILE` prints a plan, `musher-meilin send plan FILE` gives a running\n"
       "match one, and `musher-meilin models` prints the nodes for an editor; see their --help.\n\n"
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
