#pragma once
// What CyberDog's manager is asked for: states, low power, OTA, power. The wire only: what is
// allowed is decided by the policy, who is asked through the controller's shell.
//
// Threads: loop thread only.

#include <functional>
#include <string>

#include "musher/controller/controller_shell.hpp"
#include "musher/controller/cyberdog/power_saving.hpp"
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
  // Asks the policy; where that leads out of LowPower, once the board has left it. TearDown and
  // Error do not wait for the board, and what the policy refuses does not wake it.
  void Ask(const event::PolicyRequested& asked, const ControllerShell::OnAnswer& done);
  void OnSwitch(std::uint8_t number);
  void OnKeep(const msg::MachineState::Request& request, const KeepReply& reply);
  void OnWakeWord();

  ControllerShell& shell_;
  PowerSaving& power_saving_;
};

}  // namespace musher::cyberdog
