#pragma once
// What arrives from the actuators: their status, their replies, the loss of their writer; and the
// deadlines for what does not arrive.

#include "musher/lifecycle/switch/commands.hpp"
#include "musher/lifecycle/switch/control.hpp"

namespace musher {

class Arrivals : StepPart {
 public:
  Arrivals(StepContext& step, Saver& saver, EmergencyStops& stops, Processes& processes,
           Commands& commands, Control& control)
      : StepPart(step),
        saver_(saver),
        stops_(stops),
        processes_(processes),
        commands_(commands),
        control_(control) {}

  void On(const event::StatusSeen& seen);
  void On(const event::Replied& replied);
  void On(const event::Vanished& vanished);

  void CheckDeadlines();
  // A rebooted host counts as another host: the status that its actuators published while the
  // processes from before the reboot were still present is used when those are lost.
  void TakeUpOthers();

 private:
  void FoundTornDown(ActuatorIndex i, const ActuatorReport& report);
  void SetUpFailed(ActuatorIndex i, const ActuatorReport& report);
  bool MayRunBeside(ActuatorIndex i, const ActuatorReport& report) const;
  bool IsImpostor(ActuatorIndex i, const ActuatorReport& report);
  void NoteOther(ActuatorIndex i, const ActuatorReport& other, std::int32_t used);
  void RecordDuplicate(ActuatorIndex i, const ActuatorReport& other, std::int32_t used);
  void LoseToOther(const event::Vanished& lost);
  void EvaluateFoundBusy(ActuatorIndex i);

  Saver& saver_;
  EmergencyStops& stops_;
  Processes& processes_;
  Commands& commands_;
  Control& control_;
};

}  // namespace musher
