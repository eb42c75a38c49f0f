#pragma once
// The whole machine as one ROS 2 managed node, <namespace>/musher: configure is SelfCheck, activate
// Active, deactivate DeActive, cleanup and shutdown TearDown, unless [ros2] of the config sets
// other states. A transition is a switch of the machine; it succeeds when the machine is in its
// target, even if some actuators are not. A manager does not switch it up where another requester
// has switched it down; a person's `ros2 lifecycle set` does.
//
// Threads: loop thread only.

#include <memory>
#include <string>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/transport/dds/ros_nodes.hpp"
#include "musher/wire/managed_node_endpoints.hpp"

namespace musher {

class ManagedMachine {
 public:
  // `instance` identifies this controller. The others must outlive it.
  static Result<std::unique_ptr<ManagedMachine>> Make(transport::Node& node, ControllerShell& shell,
                                                      const transport::RosNodes& ros_nodes,
                                                      const std::string& instance);

  // The machine has changed.
  void OnRecord();
  // A manager has not yet queried the state after its shutdown.
  bool Holds() const { return endpoints_->Holds(); }

 private:
  ManagedMachine(ControllerShell& shell, const transport::RosNodes& ros_nodes)
      : shell_(shell), ros_nodes_(ros_nodes) {}

  using Done = transport::ManagedNodeEndpoints::Done;
  Requester RequesterOf(transport::ParticipantId caller) const;
  std::string NodeOf(transport::ParticipantId caller) const;
  std::optional<Error> WhyRefusedToManager(const Ros2Transition& transition) const;
  // A command of ROS 2 Humble has no service by which it is known, and its request may come before
  // its list of nodes: a person's, which would be refused as that of a manager.
  bool Postpone(const Ros2Transition& transition, transport::ParticipantId caller,
                std::function<void()> again) const;
  std::optional<Error> WhyRefused(const Ros2Transition* transition,
                                  transport::ParticipantId caller) const;
  bool NeedsNoSwitch(const State& target) const;
  void Change(const Ros2Transition& transition, const Requester& by, const Done& done);
  void Switch(const State& target, const Requester& by, const Done& done);

  ControllerShell& shell_;
  const transport::RosNodes& ros_nodes_;
  std::unique_ptr<transport::ManagedNodeEndpoints> endpoints_;
  // Expires before late answers arrive.
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace musher
