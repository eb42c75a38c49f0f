// A module that gets no more memory dies of it, and is started again without the limit.

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "musher/test/campaign/faults/promise.hpp"
#include "musher/test/campaign/faults/resource.hpp"

namespace musher::campaign::resource {

void MemoryIsLimited(Trial& trial) {
  const std::string victim = trial.Victim({"legs", "arm", "eyes", "hands", "planner"});
  const pid_t pid = trial.robot.PidOf(victim);
  rlim_t pages = 0;
  std::ifstream("/proc/" + std::to_string(pid) + "/statm") >> pages;
  const rlim_t more = static_cast<rlim_t>(trial.random.Between(1, 32)) << 20U;
  trial.Drawn("more", std::to_string(more >> 20U) + " MiB");
  const rlimit limit{pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + more, RLIM_INFINITY};
  trial.Require(prlimit(pid, RLIMIT_AS, &limit, nullptr) == 0, "prlimit(RLIMIT_AS)");
  trial.Struck();
  trial.robot.board(victim).end = End::kAllocate;
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  Relieve(trial.robot.board(victim));
  AwaitPromise(trial, victim, Loss::kFailure);
}

}  // namespace musher::campaign::resource
