// A module that gets no more memory crashes, and is restarted without the limit.

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"

namespace musher::fault_injection::resource {

void MemoryIsLimited(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands", "planner"});
  const pid_t pid = run.robot.PidOf(victim);
  rlim_t pages = 0;
  std::ifstream("/proc/" + std::to_string(pid) + "/statm") >> pages;
  const rlim_t more = static_cast<rlim_t>(run.random.Between(1, 32)) << 20U;
  run.Sampled("more", std::to_string(more >> 20U) + " MiB");
  const rlimit limit{pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + more, RLIM_INFINITY};
  run.Require(prlimit(pid, RLIMIT_AS, &limit, nullptr) == 0, "prlimit(RLIMIT_AS)");
  run.FaultInjected();
  run.robot.board(victim).end = End::kAllocate;
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  ClearFaults(run.robot.board(victim));
  AwaitExpectation(run, victim, Loss::kFailure);
}

}  // namespace musher::fault_injection::resource
