// SIGSTOP: for longer than the actuator may be silent, and for less.

#include <signal.h>

#include "musher/test/campaign/faults/process.hpp"
#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign::process {

void StoppedForLong(Trial& trial) {
  const std::string victim = trial.Victim(Modules());
  const pid_t pid = trial.robot.PidOf(victim);
  trial.Struck();
  kill(pid, SIGSTOP);
  trial.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  if (PromiseFor(victim, Loss::kFailure, trial.state()).back) {
    return trial.RecoveredIn(trial.state());  // killed and started again
  }
  // What may not be restarted is left as it is, and may come to itself.
  const std::string state = PromiseFor(victim, Loss::kFailure, trial.state()).state;
  trial.RecoveredIn(state, {victim});
  kill(pid, SIGCONT);
  trial.Require(trial.observer()
                    .Await([&](const auto& s) { return IsSettled(s, state); }, kPatience)
                    .has_value(),
                victim + " does not come back when it goes on");
}

void StoppedShortly(Trial& trial) {
  const std::string victim = trial.random.Pick(Modules());
  trial.Drawn("victim", victim);
  const int limit_ms = MemberOf(victim).checkpoint_ms > 0 ? MemberOf(victim).checkpoint_ms : 1000;
  const auto stop = Milliseconds(trial.random.Between(limit_ms / 10, limit_ms * 6 / 10));
  trial.Drawn("for", std::to_string(ToMilliseconds(stop)) + " ms");
  const pid_t pid = trial.robot.PidOf(victim);
  trial.Struck();
  kill(pid, SIGSTOP);
  trial.LetPass(stop);
  kill(pid, SIGCONT);
  // On a busy machine it may have been longer than it should: then anything may be said of it.
  if (std::chrono::steady_clock::now() - trial.struck() > Milliseconds(limit_ms * 9 / 10)) {
    trial.MayBeHurt(victim);
  }
  trial.LetPass(Milliseconds(limit_ms));  // a false verdict would come within that
  trial.RecoveredIn(trial.state());
}

}  // namespace musher::campaign::process
