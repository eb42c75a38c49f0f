// An actuator exits in each SetUp: it is given up after its restarts, and the machine goes to
// on_lost.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/process.hpp"

namespace musher::fault_injection::process {

void CrashesRepeatedly(FaultRun& run) {
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands"});
  Board& board = run.robot.board(victim);
  board.exit_code = 3;
  board.end_in = IndexOfState("SetUp");
  board.end = End::kExit;
  const int before = board.starts;
  const pid_t pid = run.robot.PidOf(victim);
  run.FaultInjected();
  kill(pid, SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  AwaitExpectation(run, victim, Loss::kForGood);
  // The failed starts, and the one that an operator requested.
  const int starts = board.starts - before;
  run.Expect(starts == kRestartLimit + 1, "started " + std::to_string(starts) + " times");
}

}  // namespace musher::fault_injection::process
