#pragma once
// The opposite of ros2_states.hpp: an actuator, or the whole machine, as a managed node for ROS 2's
// tools. Pure: observed states and requests go in, the node's state comes out.
//
// The node's state follows from the Musher state:
//
//   Uninitialized, SetUp, Error ▶ unconfigured     Active   ▶ active
//   all others                  ▶ inactive         TearDown ▶ finalized
//
// While a callback runs, the node is in a transition state ("activating"). A manager's transition
// may end in another state than the mapped one: after its cleanup the Musher state may be DeActive,
// and the node is unconfigured. That holds until another command changes the state.
//
// Threads: none; a plain value.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/config/ros2_states.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// An edge of the graph of a managed node, as in lifecycle_msgs: a transition that can be requested
// leads to a transition state, and its end leads from there to a primary state.
struct Ros2Edge {
  std::uint8_t id = 0;
  std::string_view label;
  Ros2State start = Ros2State::kUnknown;
  Ros2State goal = Ros2State::kUnknown;
};

// All edges, in ROS 2's order, and all states.
std::span<const Ros2Edge> Ros2Graph();
std::span<const Ros2State> Ros2States();
// The edges that can be requested in `state`; none in a transition state.
std::vector<Ros2Edge> RequestableIn(Ros2State state);
// The label in lifecycle_msgs: "cleaningup".
std::string_view Ros2StateLabel(Ros2State state);

class ManagedNode {
 public:
  // The current Musher state, and the state whose callback runs; empty: none.
  void Observe(const State& state, const State& target);

  // Starts the requested transition, by its label, or by its id if the label is empty. The Error
  // states why this transition is not available now.
  Result<Ros2Transition> Begin(std::uint8_t id, std::string_view label);
  // That transition has ended.
  void End(bool success);

  Ros2State state() const;
  bool under_way() const { return under_way_.has_value(); }
  const State& musher_state() const { return state_; }

  friend bool operator==(const ManagedNode&, const ManagedNode&) = default;

 private:
  State state_{kUninitialized};
  State target_;
  std::optional<Ros2Transition> under_way_;
  State before_;                     // the Musher state when it began
  std::optional<Ros2State> led_to_;  // the result of the last one; nullopt: it follows from state_
};

// The actuator's state that a transition stands for; empty: no callback has to run; nullopt: the
// actuator has no such state. A cleanup never ends the process; shutdown does.
std::optional<State> TargetOf(const Ros2Transition& transition, const ActuatorConfig& actuator,
                              const MachineConfig& machine);
// The same for the machine, from its [ros2] table.
std::optional<State> TargetOf(const Ros2Transition& transition, const MachineConfig& machine);

// A rate-limited log of refused requests: the first one at once, then at most one line in ten
// seconds with the number of refusals since the last line. What a flood leaves uncounted is logged
// with the next refusal.
class RefusalLog {
 public:
  // The line to log now; nullopt: none.
  std::optional<std::string> Refused(const std::string& what, Time now);

  friend bool operator==(const RefusalLog&, const RefusalLog&) = default;

 private:
  std::optional<Time> logged_at_;
  std::uint64_t suppressed_ = 0;
};

}  // namespace musher
