#pragma once
// One controller leads: the one with the higher epoch. The other releases control at once and
// changes nothing more, also where it receives no heartbeat of the first: then its actuators show
// the higher epoch.

#include <string>

#include "musher/lifecycle/switch/control.hpp"
#include "musher/lifecycle/switch/tear_down.hpp"

namespace musher {

class Authority : StepPart {
 public:
  Authority(StepContext& step, Control& control, Switches& switches, TearDown& tear_down)
      : StepPart(step), control_(control), switches_(switches), tear_down_(tear_down) {}

  void On(const event::RivalSeen& rival);
  // Releases control if an actuator that this controller has taken control of reports a higher
  // epoch. After a start by a supervisor, also if an actuator of another host that is left alone
  // for the grace reports a higher epoch than before, and it is not the epoch of a predecessor.
  // Returns whether control is released.
  bool ReleaseIfReplaced(ActuatorIndex i, const ActuatorReport& report);
  // Releases control if another controller has replaced this one since its start by a supervisor
  // (Control::IsReplacedElsewhere()).
  void ReleaseIfReplacedElsewhere();

 private:
  bool AtWork() const;
  void Release(const std::string& rival, Epoch epoch, bool elsewhere);
  void NoteLedElsewhere();

  Control& control_;
  Switches& switches_;
  TearDown& tear_down_;
};

}  // namespace musher
