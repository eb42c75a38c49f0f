// SIGSTOP: for longer than the actuator may be silent, and for less.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/process.hpp"

namespace musher::fault_injection::process {

void StoppedForLong(FaultRun& run) {
  const std::string victim = run.Victim(Modules());
  const pid_t pid = run.robot.PidOf(victim);
  run.Struck();
  kill(pid, SIGSTOP);
  run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  if (ExpectationFor(victim, Loss::kFailure, run.state()).back) {
    return run.RecoveredIn(run.state());  // killed and started again
  }
  // What may not be restarted is left as it is, and may come to itself.
  const std::string state = ExpectationFor(victim, Loss::kFailure, run.state()).state;
  run.RecoveredIn(state, {victim});
  kill(pid, SIGCONT);
  run.Require(run.observer()
                  .Await([&](const auto& s) { return IsSettled(s, state); }, kPatience)
                  .has_value(),
              victim + " does not come back when it goes on");
}

void StoppedShortly(FaultRun& run) {
  const std::string victim = run.random.Pick(Modules());
  run.Drawn("victim", victim);
  const int limit_ms = MemberOf(victim).checkpoint_ms > 0 ? MemberOf(victim).checkpoint_ms : 1000;
  const auto stop = Milliseconds(run.random.Between(limit_ms / 10, limit_ms * 6 / 10));
  run.Drawn("for", std::to_string(ToMilliseconds(stop)) + " ms");
  const pid_t pid = run.robot.PidOf(victim);
  run.Struck();
  kill(pid, SIGSTOP);
  run.LetPass(stop);
  kill(pid, SIGCONT);
  // On a busy machine it may have been longer than it should: then anything may be said of it.
  if (std::chrono::steady_clock::now() - run.struck() > Milliseconds(limit_ms * 9 / 10)) {
    run.MayBeHurt(victim);
  }
  run.LetPass(Milliseconds(limit_ms));  // a false verdict would come within that
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::process
