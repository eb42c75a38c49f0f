// musher-plan-dispatcher: executes plans for several robots. See ../README.md.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/skills/plan/dispatcher_actuator.hpp"

namespace {

int Run(const musher::program::Options& options) {
  const musher::program::EndSignals signals;  // before any thread
  const auto reading = musher::skills::ReadDispatcherFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return musher::program::kUsageError;
  musher::skills::DispatcherActuator dispatcher(options.actuator, *reading.config);
  dispatcher.CancelAt(signals);
  return musher::program::RunToEnd(dispatcher, options.state_config);
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-plan-dispatcher",
       "Executes plans for several robots: goals of the action plan_execution.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
