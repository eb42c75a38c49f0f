#pragma once
// The other side of ros2_states.hpp: an actuator, or the whole machine, as ROS 2's tools see a
// managed node. Pure: what is observed and requested goes in, the node's state comes out.
//
// The node's state follows from the own one:
//
//   Uninitialized, SetUp, Error ▶ unconfigured     Active   ▶ active
//   all others                  ▶ inactive         TearDown ▶ finalized
//
// While a callback runs, the node is on the way ("activating"). A manager's transition may lead to
// a state that says less: after its cleanup the own state may be DeActive, and the node is
// unconfigured. That holds until something else moves the node.
//
// Threads: none; a plain value.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/ros2_states.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// An edge of the graph of a managed node, as lifecycle_msgs has it: a transition that can be
// requested leads to a state on the way, and its end from there to a state in which a node stays.
struct Ros2Edge {
  std::uint8_t id = 0;
  std::string_view label;
  Ros2State start = Ros2State::kUnknown;
  Ros2State goal = Ros2State::kUnknown;
};

// All of them, in ROS 2's order, and all states.
std::span<const Ros2Edge> Ros2Graph();
std::span<const Ros2State> Ros2States();
// Those that can be requested in `state`; none on the way.
std::vector<Ros2Edge> RequestableIn(Ros2State state);
// As lifecycle_msgs writes it: "cleaningup".
std::string_view Ros2StateLabel(Ros2State state);

class ManagedNode {
 public:
  // The state it is in, and the one whose callback runs; empty: none.
  void Observe(const State& state, const State& target);

  // The transition that a request means, by its label, else by its id; it is under way from now on.
  // The Error says why there is no such transition now.
  Result<Ros2Transition> Begin(std::uint8_t id, std::string_view label);
  // That transition has ended.
  void End(bool success);

  Ros2State state() const;
  bool under_way() const { return under_way_.has_value(); }
  const State& own_state() const { return state_; }

  friend bool operator==(const ManagedNode&, const ManagedNode&) = default;

 private:
  State state_{kUninitialized};
  State target_;
  std::optional<Ros2Transition> under_way_;
  State before_;                     // the own state when it began
  std::optional<Ros2State> led_to_;  // where the last one has led; nothing: it follows from state_
};

// Which state of an actuator a transition stands for; empty: nothing has to run. Nothing where the
// actuator has no such state. No cleanup ends the process: that is shutdown's.
std::optional<State> TargetOf(const Ros2Transition& transition, const ActuatorConfig& actuator,
                              const MachineConfig& machine);
// The same of the machine, by its [ros2] table.
std::optional<State> TargetOf(const Ros2Transition& transition, const MachineConfig& machine);

// Of requests that are refused: the first is told at once, then how many there were, at most every
// 10 s.
class RefusalLog {
 public:
  // The line to log now; nothing while there is none.
  std::optional<std::string> Refused(const std::string& what, Time now);

  friend bool operator==(const RefusalLog&, const RefusalLog&) = default;

 private:
  std::optional<Time> told_;
  std::uint64_t untold_ = 0;
};

}  // namespace musher
