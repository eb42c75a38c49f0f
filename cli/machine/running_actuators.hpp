#pragma once
// The running actuators of a namespace, with or without a controller: from their latched status,
// and on this host from the name that each process holds, or from the mark that a controller has
// given to the process of another protocol.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/process/child_processes.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/node.hpp"

namespace musher::cli {

// Whether it is the HostId() of a process on this computer, perhaps in a container.
bool IsOfThisBoot(const std::string& host);

class RunningActuators {
 public:
  struct Actuator {
    msg::ActuatorStatus status;                // only name and pid if no status was received
    bool has_status = true;                    // its status was received
    Time at{};                                 // when the status was received
    transport::ParticipantId participant = 0;  // of the process
    std::optional<ChildProcess> child;         // started by a controller; it holds no name
  };

  // Subscribes to the statuses. The node must outlive it.
  static Result<std::unique_ptr<RunningActuators>> Begin(transport::Node& node,
                                                         const std::string& name_space,
                                                         bool with_keys);

  // From now on only actuators of this machine count.
  void OnlyOf(const MachineIdentity& machine);
  // The machines of the actuators whose statuses were received: those on this host, or elsewhere.
  std::vector<MachineIdentity> Machines(bool here) const;
  // The actuators that are not torn down, by name.
  std::map<std::string, Actuator> Now() const;
  // All processes of the machine whose status says that they are not torn down: several hosts may
  // run one actuator, of which Now() has one.
  std::vector<Actuator> All() const;
  bool HasStatusOf(const std::string& actuator) const { return Received().contains(actuator); }
  // Whether its status says so, also of a process that has exited since.
  bool IsTornDown(const std::string& actuator) const;
  // Whether a process of this computer says in its status that it is an actuator of this name of
  // another machine.
  bool IsOfAnotherMachine(const std::string& actuator) const;
  // Whether a process of the namespace is known of which no status has arrived: its participant is
  // discovered first, and its status takes several times as long over a slow link.
  bool IsAnyAwaited() const;

 private:
  RunningActuators(transport::Node& node, std::string name_space)
      : node_(node), loop_(node.loop()), name_space_(std::move(name_space)) {}

  void FindChildrenHere();
  std::map<std::string, Actuator> Received() const;  // of the machine, by name

  transport::Node& node_;
  transport::EventLoop& loop_;
  const std::string name_space_;
  MachineIdentity machine_;                             // empty: any
  std::map<transport::EndpointId, Actuator> received_;  // by the writer
  std::vector<ChildProcess> children_;                  // marked processes, found by Begin()
  std::unique_ptr<transport::Subscription> statuses_;   // last: its callbacks use all of the above
};

}  // namespace musher::cli
