// SIGSTOP of the controller, then SIGCONT.

#include <signal.h>

#include "musher/test/campaign/faults/controller.hpp"

namespace musher::campaign::controller {

// Nobody minds.
void FrozenShortly(Trial& trial) {
  const pid_t pid = trial.robot.ControllerPid();
  const auto time = Milliseconds(trial.random.Between(50, 1500));
  trial.Drawn("for", std::to_string(ToMilliseconds(time)) + " ms");
  trial.Struck();
  kill(pid, SIGSTOP);
  trial.LetPass(time);
  kill(pid, SIGCONT);
  trial.Require(trial.observer().GetStatus().ok(), "it does not answer when it goes on");
  trial.RecoveredIn(trial.state());
}

// Its actuators take themselves to on_controller_lost, where that is down; it fetches them back.
void FrozenForLong(Trial& trial) {
  const pid_t pid = trial.robot.ControllerPid();
  const bool leave = RankOf(trial.state()) > RankOf(kOnControllerLost);
  trial.Struck();
  kill(pid, SIGSTOP);
  const auto alone = [&] {
    const auto said = trial.observer().LatestOfActuators();
    return std::all_of(said.begin(), said.end(), [&](const auto& actuator) {
      return actuator.second.state == kOnControllerLost;
    });
  };
  if (leave) {
    trial.Expect(AwaitThat(alone, kPatience), "without a controller not all go to Protected");
    trial.DetectedNow();
  } else {
    trial.LetPass(Milliseconds(ControllerLostMs(Shape::kHere) + 500));
  }
  kill(pid, SIGCONT);
  trial.Require(trial.observer().GetStatus().ok(), "it does not answer when it goes on");
  trial.RecoveredIn(trial.state());
}

}  // namespace musher::campaign::controller
