// musher-planner: finds paths over a map for the robots of a machine. See README.md of the module.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/navigation/planner_server/planner_server.hpp"

namespace {

int Run(const musher::program::Options& options) {
  using Actuator = musher::navigation::ServerActuator<musher::navigation::PlannerServer>;
  return musher::program::RunModule<Actuator>(options,
                                              musher::navigation::ReadPlannerFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-planner", "Finds paths over a map for the robots of a machine.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
