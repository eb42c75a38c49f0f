#pragma once
// The link to an unmodified ROS 2 managed node: its services change_state and get_state and its
// topic transition_event. A switch to a state of the machine may take several transitions.
//
//   matched ─▶ get_state ─▶ unconfigured: configured (busy in SetUp) ─▶ set up
//                       └─▶ configured already, by an earlier controller or a person: adopted
//
// What that protocol reports:
//   - Replies get lost (a ROS server drops one that finds no matched reader within 100 ms), so only
//     a positive reply or get_state has the node's state. After an event the link calls get_state.
//   - A node with a single thread does not reply while its callback runs: during a transition no
//     reply means busy.
//   - A query does not fence: the node may still execute a request that was given up. When the link
//     detects that, the report goes busy and free once, so that the coordinator drives the node to
//     the machine's state.
//   - A transition that another client requests is reported. The coordinator drives the node back,
//     like every actuator that changes its state by itself.
//   - A node with a checkpoint is queried twice within that time. A node that does not answer is
//     hung, and its restart policy applies. It need not answer while a transition runs within its
//     time limit.
//
// Threads: loop thread only.

#include <memory>
#include <optional>
#include <vector>

#include "musher/controller/link/foreign_link.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/lifecycle_msgs/transition_event.hpp"
#include "musher/transport/service.hpp"

namespace musher {

class Ros2Link : public ForeignLink {
 public:
  static Result<std::unique_ptr<ActuatorLink>> Make(transport::Node& node,
                                                    const MachineConfig& config,
                                                    ActuatorIndex actuator, Emit emit);

 private:
  using ForeignLink::ForeignLink;

  Result<> Open();
  void OnMatchChanged();

  void OnAppeared() override;
  void OnLost() override;
  void Drive() override;
  void Inquire(const QueryCommand& query) override;
  void Compare() override;

  // Polls get_state until a reply says that no transition is running.
  void Look();
  void LookAt(Time when);
  void OnLooked(Ros2State state);
  void OnFirstLook();
  void OnLookedWhileDriving();
  void OnLookedWhileFree(Ros2State before, bool revived);
  void OnEvent(const msg::TransitionEvent& event, const transport::SampleInfo& info);

  // Driving.
  void Proceed();
  void Transit(const Ros2Transition& step);
  void OnChanged(const Result<msg::ChangeState::Response>& reply);
  void Finish(Verdict verdict, std::int32_t code = kCodeOk, const std::string& message = "");
  void AnswerQueries();
  transport::LoopHandlePtr QueryTimer(std::uint64_t serial, Time when);
  void OnQueryUnanswered(std::uint64_t serial);
  bool MayBeInCallback() const;

  State StateIn(Ros2State state) const;
  std::optional<State> AdoptedState(Ros2State state) const;
  Ros2State GoalNow() const;
  Ros2State GoalOf(const State& state) const { return Ros2GoalOf(actuator().ros2_states, state); }

  struct PendingQuery {
    CommandNumber number = 0;
    std::uint64_t serial = 0;  // several may have the same number
    Time until{};              // without an answer the node is mute then
    transport::LoopHandlePtr timeout;
  };

  Ros2State known_ = Ros2State::kUnknown;  // the last primary state that was reported
  bool set_up_ = false;
  std::optional<Ros2Transition> step_;  // requested, its end not known yet
  bool step_over_ = false;              // it has ended, but the node's state is not known
  int steps_done_ = 0;                  // of the command under way
  std::uint64_t era_ = 0;  // increases with each change of what is awaited: replies to earlier
                           // requests are ignored
  bool stray_ = false;     // the node may still execute a request that was given up
  bool strayed_ = false;   // … and has done so
  bool mute_ = false;      // it did not reply to a query
  std::vector<PendingQuery> queries_;
  std::uint64_t next_query_ = 1;
  transport::LoopHandlePtr look_;
  std::unique_ptr<transport::Client<msg::ChangeState>> change_;
  std::unique_ptr<transport::Client<msg::GetState>> get_;
  std::unique_ptr<transport::Subscription> events_;  // last: its callback uses all of the above
};

}  // namespace musher
