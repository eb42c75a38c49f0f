#pragma once
// The link to an actuator of Musher's own protocol: the command service. Its latched status comes
// over a topic that all actuators share, which the shell listens to.
//
// A killed process stays matched until its lease expires, and what is sent to it alone is lost. So
// a command waits until the process that publishes the status is matched.
//
// Threads: loop thread only.

#include <memory>
#include <string>
#include <vector>

#include "musher/controller/link/actuator_link.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class MusherLink : public ActuatorLink {
 public:
  static Result<std::unique_ptr<ActuatorLink>> Make(transport::Node& node,
                                                    const MachineConfig& config,
                                                    ActuatorIndex actuator, Emit emit);

  void Switch(const SwitchCommand& command) override;
  void Query(const QueryCommand& command) override;
  void OnMachine(const MachineIdentity& machine, const std::string& host) override {
    machine_ = machine;
    host_ = host;
  }
  void OnPeer(transport::ParticipantId participant) override;

 private:
  MusherLink(std::string name, ActuatorIndex actuator, Emit emit)
      : name_(std::move(name)), actuator_(actuator), emit_(std::move(emit)) {}

  void SendOrHold(const msg::ActuatorCommand::Request& request);
  bool PeerIsMatched() const;
  void SendHeld();
  void Call(msg::ActuatorCommand::Request request);
  bool IsOfOtherMachine(const msg::ActuatorStatus& status) const;

  const std::string name_;
  const ActuatorIndex actuator_;
  const Emit emit_;
  MachineIdentity machine_;
  std::string host_;                   // of the controller
  transport::ParticipantId peer_ = 0;  // 0: any
  std::vector<msg::ActuatorCommand::Request> held_;
  std::unique_ptr<transport::Client<msg::ActuatorCommand>> client_;  // last: it uses the others
};

}  // namespace musher
