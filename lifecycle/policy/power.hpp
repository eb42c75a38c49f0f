#pragma once
// Power-off and reboot: TearDown, then the command; when the time expires, the command regardless.
// Times are of the steady clock, whatever clock the rest of the policy uses.

#include "musher/lifecycle/step/saver.hpp"
#include "musher/lifecycle/step/step_part.hpp"

namespace musher {

class Power : StepPart {
 public:
  Power(StepContext& step, Saver& saver) : StepPart(step), saver_(saver) {}

  void Begin(bool reboot, Time tear_down_at, RecordId cause, const Requester& by);
  // Gives the command, once. `in_time`: the machine is torn down.
  void Command(bool in_time);
  // The same when the time for TearDown has expired.
  void Force();
  // Goes on with what an earlier controller had accepted, if a supervisor has `restarted` this one
  // after that, in the same boot; else it is over.
  void Resume(bool restarted);

 private:
  void Store(PowerAhead ahead);

  Saver& saver_;
};

// When the power-off is due, or a switch of the policy is to be retried: by the steady clock.
std::optional<Time> NextPowerDeadline(const Machine& machine);

}  // namespace musher
