// musher-wedding: the wedding robot's show. See README.md in this folder.

#include <string_view>

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/wedding/show_config.hpp"
#include "musher/modules/wedding/tool/tool.hpp"
#include "musher/modules/wedding/wedding_robot.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::wedding::WeddingRobot>(
      options, musher::wedding::ReadWeddingFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view command = argc > 1 ? argv[1] : "";
  if (command == "replay") return musher::wedding::tool::Replay(argc - 1, argv + 1);
  if (command == "send") return musher::wedding::tool::PublishInput(argc - 1, argv + 1);
  return musher::program::Main(
      argc, argv,
      {"musher-wedding", "The show of the wedding robot, as the actuator wedding.",
       "`musher-wedding send` publishes inputs of a running show, `musher-wedding replay` replays\n"
       "a recorded one; see their --help.\n\n"
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
