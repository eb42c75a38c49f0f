// SIGSTOP of the controller, then SIGCONT.

#include <signal.h>

#include "musher/test/fault_injection/faults/controller.hpp"

namespace musher::fault_injection::controller {

// Shorter than any timeout: nothing changes.
void FrozenShortly(FaultRun& run) {
  const pid_t pid = run.robot.RunningController();
  const auto time = Milliseconds(run.random.Between(50, 1500));
  run.Sampled("for", std::to_string(ToMilliseconds(time)) + " ms");
  run.FaultInjected();
  kill(pid, SIGSTOP);
  run.LetPass(time);
  kill(pid, SIGCONT);
  run.Require(run.observer().GetStatus().ok(), "it does not reply after SIGCONT");
  run.RecoveredIn(run.state());
}

// Its actuators switch to on_controller_lost by themselves, if that is less active; the controller
// switches them back.
void FrozenForLong(FaultRun& run) {
  const pid_t pid = run.robot.RunningController();
  const bool leave = RankOf(run.state()) > RankOf(kOnControllerLost);
  run.FaultInjected();
  kill(pid, SIGSTOP);
  const auto alone = [&] {
    const auto reports = run.observer().LatestOfActuators();
    return std::all_of(reports.begin(), reports.end(), [&](const auto& actuator) {
      return actuator.second.state == kOnControllerLost;
    });
  };
  if (leave) {
    run.Expect(AwaitThat(alone, kTimeout), "without a controller not all go to Protected");
    run.DetectedNow();
  } else {
    run.LetPass(Milliseconds(ControllerLostMs(Shape::kHere) + 500));
  }
  kill(pid, SIGCONT);
  run.Require(run.observer().GetStatus().ok(), "it does not reply after SIGCONT");
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::controller
