// musher-meilin-planner: plans for a field whose boxes are known. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/meilin/plan/planner_actuator.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::meilin::PlannerActuator>(
      options, musher::meilin::ReadPlannerFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-meilin-planner", "Finds the plans of a competition robot for a map of boxes.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
