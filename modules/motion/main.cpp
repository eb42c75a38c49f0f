// musher-motion-manager: the actuator that moves the body. See README.md in this folder.

#include <utility>

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/motion/motion_manager.hpp"

namespace {

using musher::program::kUsageError;
using musher::program::PrintErrors;

constexpr const char* kFooter = R"(
FILE, every key of which may be left out:
  motions = "motions.toml"  # the motion id table, relative to FILE
  [priority]                # of sources: debug, app, audio, vis, blutele, algo
  [board]                   # kind = "topic" or "lcm", command_url, response_url, localization_url,
                            # interface, board, ttl; wait_ms, silent_ms, feedback_ms

Exit codes: 0 torn down; 1 SetUp failed; 2 usage or config.)";

int Run(const musher::program::Options& options) {
  musher::Parsed<musher::motion::MotionConfig> config =
      musher::motion::ReadMotionConfigFile(options.file);
  PrintErrors(config.diagnostics);
  if (!config.config) return kUsageError;
  musher::motion::TableReading table = musher::motion::ReadTableFile(config.config->motions);
  PrintErrors(table.diagnostics);
  if (!table.table) return kUsageError;
  musher::motion::MotionManager manager(options.actuator, *std::move(config.config),
                                        *std::move(table.table));
  return musher::program::RunToEnd(manager, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-motion-manager",
       "The actuator that moves the body: servo and result commands, by the machine's state.",
       kFooter},
      Run);
}
