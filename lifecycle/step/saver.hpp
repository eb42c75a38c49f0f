#pragma once
// What has to survive the controller: handed to the disk thread, which only TearDown waits for, and
// saved once the disk thread reports it.

#include <vector>

#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

class Saver : StepPart {
 public:
  using StepPart::StepPart;

  void Save(Stored what);
  // Saves the actuators on other hosts, when they have changed.
  void NoteHosts();
  void On(const event::SaveEnded& ended);

 private:
  std::vector<RemoteActuator> RemoteActuators() const;
  bool IsElsewhere(ActuatorIndex i) const;
};

}  // namespace musher
