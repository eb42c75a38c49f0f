#include "musher/test/protocols/ros_managed_node.hpp"

#include <array>
#include <utility>

namespace musher::testing {
namespace {

using S = Ros2State;

constexpr std::array<Ros2Transition, 7> kTransitions = {{
    {1, "configure", S::kUnconfigured, S::kConfiguring, S::kInactive},
    {2, "cleanup", S::kInactive, S::kCleaningUp, S::kUnconfigured},
    {3, "activate", S::kInactive, S::kActivating, S::kActive},
    {4, "deactivate", S::kActive, S::kDeactivating, S::kInactive},
    {5, "shutdown", S::kUnconfigured, S::kShuttingDown, S::kFinalized},
    {6, "shutdown", S::kInactive, S::kShuttingDown, S::kFinalized},
    {7, "shutdown", S::kActive, S::kShuttingDown, S::kFinalized},
}};

}  // namespace

RosManagedNode::RosManagedNode(transport::Node& node, const std::string& name) : node_(node) {
  events_ =
      transport::MakePublisher<msg::TransitionEvent>(node, name + "/transition_event").value();
  change_ = transport::MakeServer<msg::ChangeState>(
                node, name + "/change_state",
                [this](const msg::ChangeState::Request& request, auto reply) {
                  auto work = [this, id = request.transition.id, reply] {
                    Begin(id, [this, reply](bool success) {
                      if (lost_change_replies-- <= 0) reply({success});
                    });
                  };
                  if (holds_changes) return held_.push_back(std::move(work));
                  Handle(std::move(work));
                })
                .value();
  get_ = transport::MakeServer<msg::GetState>(
             node, name + "/get_state",
             [this](const msg::GetState::Request&, auto reply) {
               Handle([this, reply] {
                 if (lost_get_replies-- > 0) return;
                 const msg::State now{static_cast<std::uint8_t>(state_),
                                      std::string(Ros2StateName(state_))};
                 if (!holds_looks) return reply({now});
                 held_looks_.push_back([reply, now] { reply({now}); });
               });
             })
             .value();
}

void RosManagedNode::Handle(std::function<void()> work) {
  queue_.push_back(std::move(work));
  HandleQueued();
}

void RosManagedNode::HandleQueued() {
  while (!busy_ && !frozen && !queue_.empty()) {
    const auto work = std::move(queue_.front());
    queue_.pop_front();
    work();
  }
}

void RosManagedNode::Change(const std::string& transition) {
  for (const Ros2Transition& t : kTransitions) {
    if (t.name == transition && t.from == state_) {
      return Handle([this, id = t.id] { Begin(id, [](bool) {}); });
    }
  }
}

void RosManagedNode::Release() {
  holds_changes = holds_looks = false;
  for (auto& answer : std::exchange(held_looks_, {})) answer();
  for (auto& work : std::exchange(held_, {})) Handle(std::move(work));
}

void RosManagedNode::Begin(std::uint8_t id, Done done) {
  for (const Ros2Transition& t : kTransitions) {
    if (t.id != id || t.from != state_) continue;
    log_.emplace_back(t.name);
    if (on_callback) on_callback(log_.back());
    const Callback callback = script[std::string(t.name)];
    MoveTo(t.by);
    busy_ = true;
    end_ = node_.loop().At(
        node_.loop().Now() + callback.takes,
        [this, t, callback, done = std::move(done)] { EndCallback(t, callback.outcome, done); });
    return;
  }
  done(false);  // there is no such transition from here
}

void RosManagedNode::EndCallback(const Ros2Transition& step, Outcome outcome, const Done& done) {
  switch (outcome) {
    case Outcome::kSuccess:
      MoveTo(step.to);
      break;
    case Outcome::kFailure:
      MoveTo(step.from);
      break;
    case Outcome::kError:
      MoveTo(S::kErrorProcessing);
      MoveTo(recovers ? S::kUnconfigured : S::kFinalized);
      break;
  }
  busy_ = false;
  done(outcome == Outcome::kSuccess);
  HandleQueued();
}

void RosManagedNode::MoveTo(Ros2State state) {
  msg::TransitionEvent event;
  event.start_state.id = static_cast<std::uint8_t>(state_);
  event.goal_state.id = static_cast<std::uint8_t>(state);
  state_ = state;
  if (publishes_events) static_cast<void>(events_->Publish(event));
}

}  // namespace musher::testing
