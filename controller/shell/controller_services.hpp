#pragma once
// The services of a controller under <namespace>/musher/: set_state, restart_actuator,
// release_emergency_stop, request_policy, get_status, get_capabilities, get_plan, get_switch and
// get_history, for the CLI and for any ROS 2 node. They are offered only while the controller
// leads: an earlier request waits at its client for the next leader. Processes of this host may
// call them by `here` as well, which needs neither discovery nor a network.
//
// Threads: loop thread only.

#include <memory>
#include <string>

#include "musher/controller/journal/history_reader.hpp"
#include "musher/controller/shell/controller_shell.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/transport/dds/ros_nodes.hpp"
#include "musher/transport/host_calls.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class ControllerServices {
 public:
  // `read_history` is empty where there is no journal. What it reads by and the shell must outlive
  // the services. `here` may be null, and so may `ros_nodes`, which name the callers.
  static Result<std::unique_ptr<ControllerServices>> Make(
      transport::Node& node, ControllerShell& shell, ReadHistory read_history,
      std::unique_ptr<transport::HostServer> here = nullptr,
      const transport::RosNodes* ros_nodes = nullptr);

  // Whether the answer to a request that changes something waits until its client can be reached.
  bool HoldsAnswers() const {
    const auto holds = [](const auto& server) { return server && server->Holds(); };
    return holds(set_state_) || holds(restart_actuator_) || holds(release_emergency_stop_) ||
           holds(request_policy_);
  }

 private:
  ControllerServices(transport::Node& node, ControllerShell& shell, ReadHistory read_history,
                     std::unique_ptr<transport::HostServer> here,
                     const transport::RosNodes* ros_nodes);
  Result<> Open();

  template <class S>
  using Reply = typename transport::Server<S>::Reply;
  template <class S>
  using Handler = void (ControllerServices::*)(const typename S::Request& request,
                                               const Reply<S>& reply,
                                               transport::ParticipantId caller);
  // Serves S over DDS, and to this host.
  template <class S>
  Result<> Serve(std::unique_ptr<transport::Server<S>>& server, const char* name,
                 Handler<S> handler);

  // The name that a request gives, else that of the ROS 2 node which has sent it to `service`.
  std::string RequesterOf(const std::string& by, const char* service,
                          transport::ParticipantId caller) const;
  void OnSetState(const msg::SetState::Request& request, const Reply<msg::SetState>& reply,
                  transport::ParticipantId caller);
  void OnRestart(const msg::RestartActuator::Request& request,
                 const Reply<msg::RestartActuator>& reply, transport::ParticipantId caller);
  void OnRelease(const msg::ReleaseEmergencyStop::Request& request,
                 const Reply<msg::ReleaseEmergencyStop>& reply, transport::ParticipantId caller);
  void OnRequestPolicy(const msg::RequestPolicy::Request& request,
                       const Reply<msg::RequestPolicy>& reply, transport::ParticipantId caller);
  void OnGetStatus(const msg::GetStatus::Request& request, const Reply<msg::GetStatus>& reply,
                   transport::ParticipantId caller);
  void OnGetCapabilities(const msg::GetCapabilities::Request& request,
                         const Reply<msg::GetCapabilities>& reply, transport::ParticipantId caller);
  void OnGetPlan(const msg::GetPlan::Request& request, const Reply<msg::GetPlan>& reply,
                 transport::ParticipantId caller);
  void OnGetSwitch(const msg::GetSwitch::Request& request, const Reply<msg::GetSwitch>& reply,
                   transport::ParticipantId caller);
  void ReplyInterrupted(msg::GetSwitch::Response response, const Reply<msg::GetSwitch>& reply);
  void OnGetHistory(const msg::GetHistory::Request& request, const Reply<msg::GetHistory>& reply,
                    transport::ParticipantId caller);

  transport::Node& node_;
  ControllerShell& shell_;
  const ReadHistory read_history_;
  const std::unique_ptr<transport::HostServer> here_;
  const transport::RosNodes* const ros_nodes_;
  std::unique_ptr<transport::Server<msg::SetState>> set_state_;
  std::unique_ptr<transport::Server<msg::RestartActuator>> restart_actuator_;
  std::unique_ptr<transport::Server<msg::ReleaseEmergencyStop>> release_emergency_stop_;
  std::unique_ptr<transport::Server<msg::RequestPolicy>> request_policy_;
  std::unique_ptr<transport::Server<msg::GetStatus>> get_status_;
  std::unique_ptr<transport::Server<msg::GetCapabilities>> get_capabilities_;
  std::unique_ptr<transport::Server<msg::GetPlan>> get_plan_;
  std::unique_ptr<transport::Server<msg::GetSwitch>> get_switch_;
  std::unique_ptr<transport::Server<msg::GetHistory>> get_history_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for answers that come later
};

}  // namespace musher
