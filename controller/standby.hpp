#pragma once
// A controller that stands by on another host: what it receives of the machine, and what the
// machine's last controller has published. It sends nothing but its report to the commands of its
// host (client/standby_call.hpp). When it leads: lifecycle/coordinator/failover.hpp.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/client/standby_call.hpp"
#include "musher/lifecycle/coordinator/failover.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/lifecycle/machine/stored.hpp"
#include "musher/lifecycle/step/event.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// What the next controller has to know of the actuators, by the last status of the one before it.
// One that was not up then, and was not being started again, is not started: nothing that a person
// has torn down comes on by a fail-over.
std::vector<StoredActuator> StoredActuatorsOf(const MachineConfig& config,
                                              const msg::MachineStatus& status);

// The policy that the next controller begins with. The level of the battery is that of the last
// status; where that knows no battery, the lower one of it and of `own`, what this host has stored.
// A power-off that was accepted on either is not gone on with: its command ends this host.
StoredPolicy StoredPolicyOf(const MachineConfig& config, const msg::MachineStatus& status,
                            StoredPolicy own);

// Completes how the next controller begins, by the last status of the one before it. What the
// folder of this host has is of the last time that this host led.
void GoOnFrom(const MachineConfig& config, const msg::MachineStatus& status, event::Begin& begin);

class Standby {
 public:
  using IdentityOf = std::function<MachineIdentity()>;
  // `node` and `config`, which has a failover_ms, must outlive it. `identity`: of the machine,
  // whose id may not be known yet.
  static Result<std::unique_ptr<Standby>> Make(transport::Node& node, const MachineConfig& config,
                                               IdentityOf identity);

  // See StandbyDecision. To be called several times a second. A machine whose TearDown is complete
  // is led by none: what a person starts of it later has to have a controller first.
  std::string WhyNot();
  // From now on commands of this host receive what WhyNot() has returned; `name`: StandbyName().
  Result<> ReportHere(const std::string& name);
  // The last status of the controller that is gone; nullopt: none was received.
  const std::optional<msg::MachineStatus>& last_status() const { return status_; }

 private:
  Standby(transport::Node& node, const MachineConfig& config, IdentityOf identity);
  Result<> Open();
  std::string Reason();
  template <class Message, class OnMessage>
  Result<> Receive(const std::string& topic, const transport::Qos& qos, OnMessage on_message);
  void OnStatus(const msg::MachineStatus& status);
  bool IsOurs(const std::string& name, const std::string& id) const;

  transport::Node& node_;
  const MachineConfig& config_;
  const IdentityOf identity_;
  StandbyDecision decision_;
  std::map<std::string, transport::ParticipantId> participants_;  // of the actuators' processes
  std::optional<msg::MachineStatus> status_;
  bool received_ = false;  // a controller of the machine
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
  std::string why_not_;  // by the last WhyNot()
  std::unique_ptr<StandbyServer> server_;
};

}  // namespace musher
