#pragma once
// An actuator obeys one controller: this one takes control of an actuator that has published its
// status, and the actuator is present once it answers.
//
// A starting controller raises its epoch, once, if the actuator obeyed a higher epoch before: the
// disk of this controller is behind. A running controller never does: such an actuator obeys
// another controller, and if it was attached here before, this controller has been replaced
// (authority.hpp).

#include <cstdint>

#include "musher/lifecycle/policy/policy_memory.hpp"
#include "musher/lifecycle/step/processes.hpp"

namespace musher {

// The period at which the controller retries to take control of an actuator that has published its
// status but has not answered.
inline constexpr Duration kTakeControlPeriod = Milliseconds(500);
// The retry period where the actuator has not yet received the heartbeat of this controller.
inline constexpr Duration kIntroductionPeriod = Milliseconds(20);
// How long an actuator with a higher epoch is left alone: a controller that leads with that epoch
// sends at least two heartbeats in this time.
inline constexpr Duration kRivalGrace = Milliseconds(1200);
// The same with credentials: participants authenticate each other first.
inline constexpr Duration kSecuredRivalGrace = Milliseconds(4000);

class Control : StepPart {
 public:
  Control(StepContext& step, Saver& saver, PolicyMemory& memory, Processes& processes)
      : StepPart(step), saver_(saver), memory_(memory), processes_(processes) {}

  // Takes control of an actuator that has published its status. The answer has its status and a
  // fresh stamp, from which the actuator later computes the age of a command.
  // `denied`: the actuator has denied our epoch, which another controller has as well.
  void Take(ActuatorIndex i, bool denied = false);
  // The actuator has answered: it is present.
  void Attach(ActuatorIndex i);
  // Whether another controller has replaced this one since a supervisor has started it: the
  // actuator has an epoch that no actuator of this host has, so the epoch is not from a predecessor
  // of this controller. The actuator is left alone for the grace.
  bool IsReplacedElsewhere(ActuatorIndex i) const;
  // Whether an actuator of this host that this controller has not taken has this epoch or a higher
  // one. A controller beyond a cut link does not reach this host; if another controller does, its
  // heartbeat arrives. So the epoch is from a predecessor of this controller, which may not have
  // saved it.
  bool IsOfPredecessor(Epoch epoch) const;
  // Whether the actuator follows this controller, or did so before another one replaced it. An
  // actuator of this host has to answer for that: the last query of a predecessor may have arrived
  // before the first one of this controller. Of another host only the query is known, and perhaps a
  // controller there, which does not reach this one, has come between.
  std::optional<ActuatorIndex> StarterOf(ActuatorIndex i) const;
  bool HasTaken(const KnownActuator& known) const;

 private:
  bool MayRaise() const;
  void LeaveToOther(ActuatorIndex i);
  void RaiseEpoch();

  Saver& saver_;
  PolicyMemory& memory_;
  Processes& processes_;
};

}  // namespace musher
