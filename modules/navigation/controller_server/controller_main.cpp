// musher-controller: drives the robots of a machine along paths. See README.md of the module.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/navigation/controller_server/controller_server.hpp"

namespace {

int Run(const musher::program::Options& options) {
  using Actuator = musher::navigation::ServerActuator<musher::navigation::ControllerServer>;
  return musher::program::RunModule<Actuator>(options,
                                              musher::navigation::ReadControllerFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-controller", "Drives the robots of a machine along paths.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
