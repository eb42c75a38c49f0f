#pragma once
// Fail-over: a standby on another host leads the machine once its controller is gone. Off without
// [controller] failover_ms. What decides is which actuators a controller reaches: those that vote.
//
//   standby:  no controller received for failover_ms, and more than half of the voters say for as
//             long that they have lost theirs                                  ──▶ it leads
//   leader:   half of the voters or more are out of its reach for half of that ──▶ it releases control
//
// So two controllers never lead at a time, as long as their clocks run at the same rate: both would
// have to reach more than half. A leader whose process could not run meanwhile learns late of what
// it has lost; until then the voters refuse its commands, since they follow a higher epoch. Pure:
// the inputs are what was received, and the time.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/per_actuator.hpp"

namespace musher {

// The actuators that vote: the critical ones of Musher's protocol, which says who leads them; where
// none is critical, all of that protocol.
std::vector<ActuatorIndex> Voters(const MachineConfig& config);

class StandbyDecision {
 public:
  // `config` must outlive it, and have a failover_ms.
  StandbyDecision(const MachineConfig& config, Time now);

  // A heartbeat of a controller of this machine.
  void OnController(Time now);
  // A heartbeat of an actuator.
  void OnActuator(ActuatorIndex actuator, bool controller_lost, Time now);
  // Why this standby does not lead; "": it may. To be called several times a second: after a break
  // of its own it begins its wait again, since what it has missed says nothing.
  std::string WhyNot(Time now);

 private:
  struct Voter {
    ActuatorIndex actuator = 0;
    std::optional<Time> received;    // its last heartbeat
    std::optional<Time> lost_since;  // its heartbeats have said so since
  };

  bool HasLost(const Voter& voter, Time now) const;

  const Duration after_;
  std::vector<Voter> voters_;
  Time controller_at_{};  // of its last heartbeat, or since when this standby listens
  Time looked_at_{};      // the last WhyNot()
};

// Decides when a controller that leads has to release control.
class MajorityReach {
 public:
  // Why it has to release control: a standby may lead. "": it may go on. A controller that has not
  // yet reached more than half of the voters goes on: other hosts may boot later.
  std::string WhyRelease(const MachineConfig& config, const Machine& machine, Time now);

 private:
  bool reached_ = false;            // more than half of the voters, once
  std::optional<Time> lost_since_;  // they are out of reach
};

}  // namespace musher
