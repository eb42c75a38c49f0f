#pragma once
// binds_to: an actuator that needs another one is suspended while the other is not up. It is driven
// to the state of the machine once the other is in that state again; to be present is not enough.
// The rule depends on the present situation only, not on what led to it.

#include <string>
#include <vector>

#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

class Binding : StepPart {
 public:
  using StepPart::StepPart;

  // Returns whether something changed.
  bool SuspendAndResume();

 private:
  bool IsUp(ActuatorIndex i) const;
  bool IsKeptAtRest(ActuatorIndex i) const;
  bool IsBoundTo(ActuatorIndex i, ActuatorIndex other, PerActuator<bool>& seen) const;
  bool Suffices(ActuatorIndex needed, ActuatorIndex i) const;
  const std::string* MissingFor(ActuatorIndex bound, ActuatorIndex i,
                                PerActuator<bool>& seen) const;
  void Suspend(ActuatorIndex i, const std::string& missing);
};

}  // namespace musher
