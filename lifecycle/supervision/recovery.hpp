#pragma once
// Actuators that crashed, hang or lost their connection: a verdict, then a restart by policy or by
// request, then back to the state of the machine; and what follows when no restarts are left.

#include <string>

#include "musher/lifecycle/switch/commands.hpp"
#include "musher/lifecycle/switch/control.hpp"

namespace musher {

class Recovery : StepPart {
 public:
  Recovery(StepContext& step, Processes& processes, Commands& commands, Control& control)
      : StepPart(step), processes_(processes), commands_(commands), control_(control) {}

  void On(const event::ProcessStarted& started);
  void On(const event::ProcessNotStarted& failed);
  void On(const event::ProcessEnded& ended);
  void On(const event::HealthChanged& changed);
  void On(const event::BacktraceTaken& taken);
  void On(const event::RestartRequested& requested);

  void CheckDeadlines();

 private:
  void Recovered(ActuatorIndex i, const std::string& how);
  void Silent(ActuatorIndex i, const RecordText& how, Duration timeout);
  void EndNow(ActuatorIndex i);
  void FallBackWithout(ActuatorIndex i);
  void AssumeExited(ActuatorIndex i);
  void AwaitHost(ActuatorIndex i, bool again);
  void BeginLateSetUp(const event::ProcessStarted& started);
  void RestartFinalized(ActuatorIndex i);
  bool WasDisconnected(ActuatorIndex i) const;
  void EndForRestart(ActuatorIndex i);
  void AnswerRestarts(ActuatorIndex i);

  Processes& processes_;
  Commands& commands_;
  Control& control_;
};

}  // namespace musher
