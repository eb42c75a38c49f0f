#pragma once
// What a controller answers under <namespace>/musher/: set_state, restart_actuator,
// release_emergency_stop, request_policy, get_status, get_capabilities, get_plan and get_history,
// for the CLI and for any ROS 2 node.
//
// Threads: loop thread only; history is read from the disk on a thread of its own.

#include <memory>
#include <string>
#include <thread>

#include "musher/controller/controller_shell.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class ControllerServices {
 public:
  // Without a journal there is no history. The shell and the journal must outlive the services.
  static Result<std::unique_ptr<ControllerServices>> Make(transport::Node& node,
                                                          ControllerShell& shell, Journal* journal);

 private:
  ControllerServices(transport::Node& node, ControllerShell& shell, Journal* journal);
  Result<> Open();

  using HistoryReply = transport::Server<msg::GetHistory>::Reply;
  void OnSetState(const msg::SetState::Request& request,
                  const transport::Server<msg::SetState>::Reply& reply);
  void OnRequestPolicy(const msg::RequestPolicy::Request& request,
                       const transport::Server<msg::RequestPolicy>::Reply& reply);
  msg::GetPlan::Response OnGetPlan(const msg::GetPlan::Request& request) const;
  void OnGetHistory(const msg::GetHistory::Request& request, HistoryReply reply);

  transport::Node& node_;
  ControllerShell& shell_;
  Journal* const journal_;
  bool reading_history_ = false;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  std::jthread history_reader_;
  std::unique_ptr<transport::Server<msg::SetState>> set_state_;
  std::unique_ptr<transport::Server<msg::RestartActuator>> restart_actuator_;
  std::unique_ptr<transport::Server<msg::ReleaseEmergencyStop>> release_emergency_stop_;
  std::unique_ptr<transport::Server<msg::RequestPolicy>> request_policy_;
  std::unique_ptr<transport::Server<msg::GetStatus>> get_status_;
  std::unique_ptr<transport::Server<msg::GetCapabilities>> get_capabilities_;
  std::unique_ptr<transport::Server<msg::GetPlan>> get_plan_;
  std::unique_ptr<transport::Server<msg::GetHistory>> get_history_;
};

}  // namespace musher
