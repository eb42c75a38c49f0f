#pragma once
// The link to an unmodified ROS 2 managed node: its services change_state and get_state and its
// topic transition_event. The way to a state of the machine may take several transitions.
//
//   seen ─▶ looked at ─▶ unconfigured: configured (busy in SetUp) ─▶ set up
//                    └─▶ configured already, by an earlier controller or a person: adopted
//
// What that protocol can and cannot tell:
//   - Replies get lost (a ROS server drops one that finds no matched reader within 100 ms), so only
//     a positive reply or get_state says where the node is. An event makes us look.
//   - A node with a single thread answers nothing while its callback runs: as long as a transition
//     is owed, silence means busy.
//   - A question does not fence: a request that was given up may still be carried out. When that
//     shows, the report goes busy and free once, so that the node is driven to where the machine
//     is.
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
                                                    std::size_t actuator, Emit emit);

 private:
  using ForeignLink::ForeignLink;

  Result<> Open();
  void OnMatchChanged();

  void OnAppeared() override;
  void OnGone() override;
  void Drive() override;
  void Inquire(const QueryCommand& query) override;

  // Looking: get_state, again and again until an answer says that nothing is open.
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
  void OnQueryUnanswered(std::uint64_t number);
  bool MayBeInCallback() const;

  State StateIn(Ros2State state) const;
  std::optional<State> AdoptedState(Ros2State state) const;
  Ros2State GoalNow() const;
  Ros2State GoalOf(const State& state) const { return Ros2GoalOf(actuator().ros2_states, state); }

  struct PendingQuery {
    std::uint64_t number = 0;
    transport::LoopHandlePtr timeout;
  };

  Ros2State known_ = Ros2State::kUnknown;  // the primary state it was last seen in
  bool set_up_ = false;
  std::optional<Ros2Transition> step_;  // asked for, its end not known yet
  bool step_over_ = false;              // it has ended, but where it led is not known
  int steps_done_ = 0;                  // of the order's way
  std::uint64_t era_ = 0;  // grows with each change of what is awaited: what was asked for before
                           // says nothing about it
  bool stray_ = false;     // a request that was given up may still be carried out
  bool strayed_ = false;   // … and has been
  bool mute_ = false;      // it left a question without an answer
  std::vector<PendingQuery> queries_;
  transport::LoopHandlePtr look_;
  std::unique_ptr<transport::Client<msg::ChangeState>> change_;
  std::unique_ptr<transport::Client<msg::GetState>> get_;
  std::unique_ptr<transport::Subscription> events_;  // last: its callback uses all of the above
};

}  // namespace musher
