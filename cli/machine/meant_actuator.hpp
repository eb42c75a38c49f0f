#pragma once
// Which actuator of a name a request means, where several machines of a namespace have one. By
// their latched statuses, so it needs no controller:
//
//   --machine is given    the one of that machine
//   else                  the one that runs on this host, or is of the machine that this host has
//                         files of; without any, the only one
//
// A goal, and a command of an application, is received by every actuator of its name in the
// namespace. So it is refused where several machines have one, whichever is meant.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/cli/machine/link.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"

namespace musher::cli {

class MeantActuator {
 public:
  // What its refusals say of those that a request would reach.
  struct Words {
    std::string none;     // "no actuator arm of machine "
    std::string lacks;    // ", has no running actuator arm": after the machine of this host
    std::string several;  // "arm is an actuator of several machines"
  };

  // Subscribes to the statuses. Both references must outlive it.
  static Result<std::unique_ptr<MeantActuator>> Begin(Link& link, const GlobalOptions& global);

  // Why no request may be sent to the actuators of that name; nullopt: it reaches the one that is
  // meant, and no other. One whose status is not received is meant unless --machine is given. The
  // first call runs the loop until that actuator is discovered, at most for link.discovery(), and
  // until others have had time for it, too.
  std::optional<Failure> Check(const std::string& actuator);
  // The same for the actuators that serve an action, by their participants, whatever their names
  // are. One is discovered already.
  std::optional<Failure> CheckServers(
      const std::function<std::vector<transport::ParticipantId>()>& servers, const Words& words);
  // Why no request may be sent to all of these, each of which is meant: they are of several
  // machines.
  std::optional<Failure> CheckTogether(const std::vector<std::string>& actuators) const;
  // Whether a status of an actuator of that name was received.
  bool IsKnown(const std::string& actuator) const;
  // Whether each known actuator of that name is of another machine than --machine means.
  bool IsOfAnother(const std::string& actuator) const;

 private:
  MeantActuator(Link& link, const GlobalOptions& global) : link_(link), global_(global) {}
  struct Known {
    msg::ActuatorStatus status;
    transport::ParticipantId participant;
  };

  std::vector<msg::ActuatorStatus> OfName(const std::string& actuator) const;
  std::vector<msg::ActuatorStatus> OfParticipants(
      const std::vector<transport::ParticipantId>& participants) const;
  std::optional<Failure> CheckFound(const std::vector<msg::ActuatorStatus>& found,
                                    const Words& words) const;
  bool IsNamed(const msg::ActuatorStatus& status) const;

  Link& link_;
  const GlobalOptions& global_;
  std::set<std::string> had_time_;                     // to be discovered
  std::map<transport::EndpointId, Known> known_;       // by their writer
  std::unique_ptr<transport::Subscription> statuses_;  // last: its callbacks use all of the above
};

}  // namespace musher::cli
