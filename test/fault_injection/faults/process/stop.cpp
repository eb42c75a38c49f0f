// SIGSTOP: for longer than the actuator may be silent, and for less.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/process.hpp"

namespace musher::fault_injection::process {

void StoppedForLong(FaultRun& run) {
  const std::string victim = run.Victim(Modules());
  const pid_t pid = run.robot.PidOf(victim);
  run.FaultInjected();
  kill(pid, SIGSTOP);
  run.Detected(victim + " hangs", IsKnownAs(victim, "hung"));
  if (ExpectationFor(victim, Loss::kFailure, run.state()).back) {
    return run.RecoveredIn(run.state());  // killed and restarted
  }
  // An actuator that is not restarted stays frozen, and recovers when it is resumed.
  const std::string state = ExpectationFor(victim, Loss::kFailure, run.state()).state;
  run.RecoveredIn(state, {victim});
  kill(pid, SIGCONT);
  run.Require(run.observer()
                  .Await([&](const auto& s) { return IsSettled(s, state); }, kTimeout)
                  .has_value(),
              victim + " is not available after SIGCONT");
}

void StoppedShortly(FaultRun& run) {
  const std::string victim = run.random.Pick(Modules());
  run.Sampled("victim", victim);
  const int limit_ms = MemberOf(victim).checkpoint_ms > 0 ? MemberOf(victim).checkpoint_ms : 1000;
  const auto stop = Milliseconds(run.random.Between(limit_ms / 10, limit_ms * 6 / 10));
  run.Sampled("for", std::to_string(ToMilliseconds(stop)) + " ms");
  const pid_t pid = run.robot.PidOf(victim);
  run.FaultInjected();
  kill(pid, SIGSTOP);
  run.LetPass(stop);
  kill(pid, SIGCONT);
  // On a busy machine it may have been frozen for longer: then any health is accepted.
  if (std::chrono::steady_clock::now() - run.injected_at() > Milliseconds(limit_ms * 9 / 10)) {
    run.MayBeAffected(victim);
  }
  run.LetPass(Milliseconds(limit_ms));  // a false detection would happen within that
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::process
