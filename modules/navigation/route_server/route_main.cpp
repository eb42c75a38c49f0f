// musher-route: finds routes over a graph of places for the robots of a machine, and tracks them.
// See README.md of the module.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/navigation/route_server/route_server.hpp"

namespace {

int Run(const musher::program::Options& options) {
  using Actuator = musher::navigation::ServerActuator<musher::navigation::RouteServer>;
  return musher::program::RunModule<Actuator>(options,
                                              musher::navigation::ReadRouteFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-route", "Finds routes over a graph of places for the robots of a machine.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
