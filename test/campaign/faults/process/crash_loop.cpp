// Dies in each SetUp: given up after its restarts, and the machine goes where it goes without it.

#include <signal.h>

#include "musher/test/campaign/faults/process.hpp"
#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign::process {

void CrashesAgainAndAgain(Trial& trial) {
  const std::string victim = trial.Victim({"legs", "arm", "eyes", "hands"});
  Board& board = trial.robot.board(victim);
  board.exit_code = 3;
  board.end_in = IndexOfState("SetUp");
  board.end = End::kExit;
  const int before = board.starts;
  const pid_t pid = trial.robot.PidOf(victim);
  trial.Struck();
  kill(pid, SIGKILL);
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  AwaitPromise(trial, victim, Loss::kForGood);
  // Those that died, and the one that a person asked for.
  const int starts = board.starts - before;
  trial.Expect(starts == kRestartLimit + 1, "started " + std::to_string(starts) + " times");
}

}  // namespace musher::campaign::process
