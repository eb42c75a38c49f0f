// The program inside a musher-exec is killed: the actuator ends with it, and is restarted.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/process.hpp"
#include "musher/test/fault_injection/robot/processes.hpp"

namespace musher::fault_injection::process {
namespace {

pid_t Descendant(pid_t ancestor, const std::string& program) {
  for (const pid_t child : ChildrenOf(ancestor)) {
    const auto line = CommandLine(child);
    if (!line.empty() && line.front() == program) return child;
    if (const pid_t found = Descendant(child, program); found != 0) return found;
  }
  return 0;
}

}  // namespace

void WrappedProgramKilled(FaultRun& run) {
  const std::string victim = "voice";
  run.MayBeAffected(victim);
  const pid_t program = Descendant(run.robot.PidOf(victim), "sleep");
  run.Require(program != 0, "musher-exec runs no program");
  run.FaultInjected();
  kill(program, SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  AwaitExpectation(run, victim, Loss::kFailure);
}

}  // namespace musher::fault_injection::process
