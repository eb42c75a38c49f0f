#pragma once
// Drives single actuators to the state of the machine: actuators of a late stage, restarted and
// overdue actuators. In a step of a start it drives down what an undone switch has left too active.
// Switches go first: an actuator that joins waits for them.

#include <string>

#include "musher/lifecycle/switch/commands.hpp"

namespace musher {

class LateActuators : StepPart {
 public:
  LateActuators(StepContext& step, Commands& commands) : StepPart(step), commands_(commands) {}

  // Returns whether a change may let other actuators proceed.
  bool DriveLateOnes();

 private:
  bool IsOfAnother(ActuatorIndex i) const;
  bool IsToBeChecked(ActuatorIndex i);
  bool LowerLateOnes();
  bool Lower(ActuatorIndex i);
  bool WaitsForRequest(ActuatorIndex i) const;
  bool IsStopped(ActuatorIndex i) const;
  bool IsFoundBelow(ActuatorIndex i) const;
  void Hold(ActuatorIndex i);
  bool MayJoin(ActuatorIndex i, std::optional<RecordText>& blocker) const;
  void Join(ActuatorIndex i);

  Commands& commands_;
};

}  // namespace musher
