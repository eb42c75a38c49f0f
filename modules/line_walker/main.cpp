// musher-line-walker: walks in a lane between two yellow lines. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/line_walker/walker_actuator.hpp"
#include "musher/modules/line_walker/walker_config.hpp"

namespace {

int Run(const musher::program::Options& options) {
  const musher::Parsed<musher::line_walker::WalkerConfig> reading =
      musher::line_walker::ReadWalkerFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return musher::program::kUsageError;
  musher::line_walker::WalkerActuator walker(options.actuator, *reading.config);
  return musher::program::RunToEnd(walker, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-line-walker", "Walks in a lane between two yellow lines, to its end line.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
