#pragma once
// Drives one actuator on its own to the state of the machine: actuators of late stages, restarted
// ones, and those that were overdue. While the machine is in a step of a start, it drives down
// those that have come back from an undone switch. Switches go first; joining waits for them.

#include <string>

#include "musher/lifecycle/switch/commands.hpp"

namespace musher {

class LateActuators : StepPart {
 public:
  LateActuators(StepContext& step, Commands& commands) : StepPart(step), commands_(commands) {}

  // Returns whether a change may let other actuators proceed.
  bool DriveLateOnes();

 private:
  bool IsToBeChecked(ActuatorIndex i);
  bool LowerLateOnes();
  bool Lower(ActuatorIndex i);
  bool StoppedOnTheLevel(ActuatorIndex i) const;
  bool IsStopped(ActuatorIndex i) const;
  void Hold(ActuatorIndex i);
  bool MayJoin(ActuatorIndex i, std::optional<RecordText>& blocker) const;
  void Join(ActuatorIndex i);

  Commands& commands_;
};

}  // namespace musher
