#pragma once
// The requests to CyberDog's manager: states, low power, OTA, power. Only the wire: the policy
// decides what is allowed, through the controller's shell.
//
// Threads: loop thread only.

#include <functional>
#include <string>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/cyberdog/power_saving.hpp"
#include "musher/messages/protocol/manager.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Requests {
 public:
  // All must outlive it.
  Requests(transport::Endpoints& endpoints, ControllerShell& shell, PowerSaving& power_saving);

 private:
  using KeepReply = transport::Server<msg::MachineState>::Reply;

  void ServeStates(transport::Endpoints& endpoints);
  void ServePower(transport::Endpoints& endpoints);
  void ServeSetBool(transport::Endpoints& endpoints, const char* name, PolicyRequest what);
  // Sends a request to the policy; if it leads out of LowPower, once the board has left low power.
  // TearDown and Error do not wait for the board, and a refused request does not wake it. A request
  // of an actuator of another robot, such as by its power key, is refused.
  void Request(const event::PolicyRequested& requested, transport::ParticipantId caller,
               const ControllerShell::OnAnswer& done);
  void OnSwitch(std::uint8_t number, transport::ParticipantId caller);
  void OnKeep(const msg::MachineState::Request& request, const KeepReply& reply,
              transport::ParticipantId caller);
  void OnWakeWord(transport::ParticipantId caller);
  // The ROS 2 node name of the participant that requests; empty: it has no ROS 2 node.
  std::string NameOf(transport::ParticipantId participant) const {
    return node_.RosNodeOf(participant);
  }

  transport::Node& node_;
  ControllerShell& shell_;
  PowerSaving& power_saving_;
};

}  // namespace musher::cyberdog
