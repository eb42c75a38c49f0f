// musher-meilin-server: one of the action servers of the competition robot. See README.md of the
// module.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/meilin/servers/server_actuator.hpp"

namespace {

int Run(const musher::program::Options& options) {
  namespace servers = musher::meilin::servers;
  return musher::program::RunModule<servers::ServerActuator>(options,
                                                             servers::ReadServerFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-meilin-server",
       "Serves an action of the competition robot: move_to_pose, suspension, arm or spear.",
       "The key `server` of the file says which.\n"
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
