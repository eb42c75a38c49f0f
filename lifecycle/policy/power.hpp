#pragma once
// Power-off and reboot: TearDown, then the command; when the time expires, the command regardless.
// Times are of the steady clock, whatever clock the rest of the policy uses.

#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

class Power : StepPart {
 public:
  using StepPart::StepPart;

  void Begin(bool reboot, Time tear_down_at, RecordId cause, const Requester& by);
  // Gives the command, once. `in_time`: the machine is torn down.
  void Command(bool in_time);
  // The same when the time for TearDown has expired.
  void Force();
};

// When the power-off is due, or a switch of the policy is to be retried: by the steady clock.
std::optional<Time> NextPowerDeadline(const Machine& machine);

}  // namespace musher
