#pragma once
// The whole machine as one ROS 2 managed node, <namespace>/musher: configure is SelfCheck, activate
// Active, deactivate DeActive, cleanup and shutdown TearDown, unless [ros2] of the config says
// otherwise. A transition is a switch of the machine; it has succeeded when the machine is in its
// target, be it without some actuators.
//
// Threads: loop thread only.

#include <memory>
#include <string>

#include "musher/controller/controller_shell.hpp"
#include "musher/transport/managed_node_endpoints.hpp"

namespace musher {

class ManagedMachine {
 public:
  // `instance` tells this controller from others. Both must outlive it.
  static Result<std::unique_ptr<ManagedMachine>> Make(transport::Node& node, ControllerShell& shell,
                                                      const std::string& instance);

  // Something has happened to the machine.
  void OnRecord();
  // A manager has not got all that it will ask for after a shutdown.
  bool Holds() const { return endpoints_->Holds(); }

 private:
  explicit ManagedMachine(ControllerShell& shell) : shell_(shell) {}

  using Done = transport::ManagedNodeEndpoints::Done;
  std::optional<Error> Refusal() const;
  void Change(const Ros2Transition& transition, const Done& done);
  void Switch(const State& target, const Done& done);

  ControllerShell& shell_;
  std::unique_ptr<transport::ManagedNodeEndpoints> endpoints_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for answers that come later
};

}  // namespace musher
