#pragma once
// A ROS 2 managed node as rclcpp's default executor makes one: a single thread, so that while a
// callback runs nothing is answered and requests queue up; transition_event before the reply. Its
// faults are on order.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/lifecycle/config/ros2_states.hpp"
#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/lifecycle_msgs/transition_event.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing {

class RosManagedNode {
 public:
  enum class Outcome { kSuccess, kFailure, kError };
  struct Callback {
    Duration takes = Milliseconds(5);
    Outcome outcome = Outcome::kSuccess;
  };

  // `name` with its namespace.
  RosManagedNode(transport::Node& node, const std::string& name);

  std::map<std::string, Callback> script;  // "configure", "activate", …
  bool recovers = true;                    // on_error succeeds
  int lost_change_replies = 0;             // so many of the next are not sent, as to a client
  int lost_get_replies = 0;                // that has not been matched
  bool publishes_events = true;
  bool holds_changes = false;  // requests for a change are still on their way, see Release()
  bool holds_looks = false;    // answers to get_state are still on their way, see Release()
  bool frozen = false;  // nothing is taken any more, as by a callback of its own that never ends

  std::function<void(const std::string&)> on_callback;  // called before each

  Ros2State state() const { return state_; }
  const std::vector<std::string>& log() const { return log_; }  // the callbacks that were begun

  // Another client switches it, or it does so itself.
  void Change(const std::string& transition);
  // The requests and answers that were on their way arrive.
  void Release();

 private:
  using Done = std::function<void(bool)>;

  void Handle(std::function<void()> work);
  void HandleQueued();
  void Begin(std::uint8_t id, Done done);
  void EndCallback(const Ros2Transition& step, Outcome outcome, const Done& done);
  void MoveTo(Ros2State state);

  transport::Node& node_;
  Ros2State state_ = Ros2State::kUnconfigured;
  bool busy_ = false;
  std::deque<std::function<void()>> queue_;
  std::vector<std::function<void()>> held_;
  std::vector<std::function<void()>> held_looks_;
  std::vector<std::string> log_;
  transport::LoopHandlePtr end_;
  std::unique_ptr<transport::Publisher<msg::TransitionEvent>> events_;
  std::unique_ptr<transport::Server<msg::ChangeState>> change_;
  std::unique_ptr<transport::Server<msg::GetState>> get_;
};

}  // namespace musher::testing
