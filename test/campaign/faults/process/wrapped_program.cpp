// The program inside a musher-exec dies: the actuator ends with it, and is started again.

#include <signal.h>

#include "musher/test/campaign/faults/process.hpp"
#include "musher/test/campaign/faults/promise.hpp"
#include "musher/test/campaign/robot/processes.hpp"

namespace musher::campaign::process {
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

void WrappedProgramKilled(Trial& trial) {
  const std::string victim = "voice";
  trial.MayBeHurt(victim);
  const pid_t program = Descendant(trial.robot.PidOf(victim), "sleep");
  trial.Require(program != 0, "musher-exec runs no program");
  trial.Struck();
  kill(program, SIGKILL);
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  AwaitPromise(trial, victim, Loss::kFailure);
}

}  // namespace musher::campaign::process
