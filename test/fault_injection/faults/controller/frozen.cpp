// SIGSTOP of the controller, then SIGCONT.

#include <signal.h>

#include "musher/test/fault_injection/faults/controller.hpp"

namespace musher::fault_injection::controller {

// Nobody minds.
void FrozenShortly(FaultRun& run) {
  const pid_t pid = run.robot.LivingController();
  const auto time = Milliseconds(run.random.Between(50, 1500));
  run.Drawn("for", std::to_string(ToMilliseconds(time)) + " ms");
  run.Struck();
  kill(pid, SIGSTOP);
  run.LetPass(time);
  kill(pid, SIGCONT);
  run.Require(run.observer().GetStatus().ok(), "it does not answer when it goes on");
  run.RecoveredIn(run.state());
}

// Its actuators take themselves to on_controller_lost, where that is down; it fetches them back.
void FrozenForLong(FaultRun& run) {
  const pid_t pid = run.robot.LivingController();
  const bool leave = RankOf(run.state()) > RankOf(kOnControllerLost);
  run.Struck();
  kill(pid, SIGSTOP);
  const auto alone = [&] {
    const auto said = run.observer().LatestOfActuators();
    return std::all_of(said.begin(), said.end(), [&](const auto& actuator) {
      return actuator.second.state == kOnControllerLost;
    });
  };
  if (leave) {
    run.Expect(AwaitThat(alone, kPatience), "without a controller not all go to Protected");
    run.DetectedNow();
  } else {
    run.LetPass(Milliseconds(ControllerLostMs(Shape::kHere) + 500));
  }
  kill(pid, SIGCONT);
  run.Require(run.observer().GetStatus().ok(), "it does not answer when it goes on");
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::controller
