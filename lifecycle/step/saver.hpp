#pragma once
// Hands what has to survive the controller to the disk thread. It counts as saved once that thread
// reports so; only TearDown waits for that.

#include <vector>

#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

class Saver : StepPart {
 public:
  using StepPart::StepPart;

  void Save(Stored what);
  // Saves the actuators on other hosts, when they have changed.
  void NoteHosts();
  // Saves what the next controller has to know of the actuators, when it has changed.
  void NoteActuators();
  void On(const event::SaveEnded& ended);

 private:
  std::vector<RemoteActuator> RemoteActuators() const;
  bool IsElsewhere(ActuatorIndex i) const;
  std::vector<StoredActuator> StoredActuators() const;
  bool IsLedAlone(ActuatorIndex i) const;
  StaysDown WhyDown(ActuatorIndex i) const;
  StoredActuator StoredOf(ActuatorIndex i) const;
};

}  // namespace musher
