#pragma once
// The services and topics of a managed node for ROS 2's tools: `ros2 lifecycle`, launch files,
// nav2's manager. Under <namespace>/<name>/: change_state, get_state, get_available_states,
// get_available_transitions, get_transition_graph and the topic transition_event; those of every
// node (node_services.hpp); and, from a manager's activate on, a bond on <namespace>/bond.
//
// Queries are always answered. A refused change_state is answered with success = false, because the
// type has no field for a reason; the reason is logged.
//
// Threads: loop thread only. The decisions are in lifecycle/ros2/managed_node.hpp and
// lifecycle/ros2/bond.hpp.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/ros2/bond.hpp"
#include "musher/lifecycle/ros2/managed_node.hpp"
#include "musher/messages/bond/status.hpp"
#include "musher/messages/lifecycle_msgs/graph.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/node_services.hpp"

namespace musher::transport {

class ManagedNodeEndpoints {
 public:
  using Done = std::function<void(const Result<>&)>;
  struct Hooks {
    // The reason why no manager may change the state now; may be empty. Called before each
    // transition (null: one that the node's state does not have), so that a flood of requests costs
    // little.
    std::function<std::optional<Error>(const Ros2Transition*, ParticipantId caller)> refusal;
    // Whether a refused request is to be considered again, because its caller is not known yet:
    // then it calls `again` once, later. May be empty.
    std::function<bool(const Ros2Transition&, ParticipantId caller, std::function<void()> again)>
        postpone;
    // Executes the transition; calls `done` once, now or later, with the reason of a failure.
    std::function<void(const Ros2Transition&, ParticipantId caller, Done done)> change;
    std::function<void(const std::string&)> log;  // may be empty
    std::vector<NodeParameter> parameters;        // that `ros2 param` shows
  };

  // `instance` identifies this process among those of the same name. `node` must outlive it.
  static Result<std::unique_ptr<ManagedNodeEndpoints>> Make(Node& node,
                                                            const std::string& name_space,
                                                            const std::string& name,
                                                            const std::string& instance,
                                                            Hooks hooks);
  // Ends the bond, which lasts as long as this node: a manager takes its end for a crash.
  ~ManagedNodeEndpoints();

  // The current Musher state, and the state whose callback runs; empty: none.
  void Observe(const State& state, const State& target);

  // A manager has ended this node and has not yet queried its state: a manager queries the node
  // after each transition, the last time when it is finalized.
  bool Holds() const;

 private:
  ManagedNodeEndpoints(Node& node, std::string name_space, std::string name, std::string instance,
                       Hooks hooks);
  Result<> Open();
  void OnChange(const msg::ChangeState::Request& request,
                const Server<msg::ChangeState>::Reply& reply, ParticipantId caller);
  void OnEnded(const Ros2Transition& transition, const Result<>& result);
  void Refuse(const std::string& transition, const std::string& why);
  void PublishEvent();
  void FormBond();
  bool OpenBond();
  void OnBondStatus(const msg::BondStatus& status);
  void EndBond();
  void AfterBond(bool publish);
  void LogBond(const std::string& line);
  void Log(const std::string& line) const;

  Node& node_;
  const std::string name_space_;
  const std::string name_;
  const std::string instance_;
  Hooks hooks_;
  ManagedNode core_;
  std::optional<Ros2State> published_;  // by the last event; the first one is only observed
  bool ended_by_manager_ = false;
  bool seen_finalized_ = false;
  RefusalLog refusals_;
  RefusalLog bond_ends_;
  Bond bond_;
  LoopHandlePtr bond_timer_;
  std::unique_ptr<Publisher<msg::BondStatus>> bond_writer_;
  std::unique_ptr<Subscription> bond_reader_;
  std::unique_ptr<Publisher<msg::TransitionEvent>> events_;
  std::unique_ptr<Server<msg::ChangeState>> change_state_;
  std::unique_ptr<Server<msg::GetState>> get_state_;
  std::unique_ptr<Server<msg::GetAvailableStates>> get_states_;
  std::unique_ptr<Server<msg::GetAvailableTransitions>> get_transitions_;
  std::unique_ptr<Server<msg::GetAvailableTransitions>> get_graph_;
  std::optional<NodeServices> of_every_node_;
  // Expires before late results arrive.
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace musher::transport
