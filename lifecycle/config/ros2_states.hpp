#pragma once
// ROS 2's managed nodes: their states and transitions, and the primary state for each state of the
// machine.
//
//   unconfigured ──configure──▶ inactive ──activate──▶ active
//    │     ▲  ◀─────cleanup────          ◀─deactivate─
//    │     └── error processing succeeded; failed ──▶ finalized
//    └─shutdown──▶ finalized, which has no transition out
//
// A failed callback leaves the node where it was. The numbers are from lifecycle_msgs.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "musher/lifecycle/state.hpp"

namespace musher {

enum class Ros2State : std::uint8_t {
  kUnknown = 0,
  kUnconfigured = 1,
  kInactive = 2,
  kActive = 3,
  kFinalized = 4,
  // Transition states; error processing follows a callback that returned ERROR or threw.
  kConfiguring = 10,
  kCleaningUp = 11,
  kShuttingDown = 12,
  kActivating = 13,
  kDeactivating = 14,
  kErrorProcessing = 15,
};

// "inactive", "error processing"; any other number is "unknown".
std::string_view Ros2StateName(Ros2State state);
// Whether a node stays in it: it is one of the four primary states.
bool IsPrimary(Ros2State state);

// A transition from one primary state to the next.
struct Ros2Transition {
  std::uint8_t id = 0;
  std::string_view name;
  Ros2State from = Ros2State::kUnknown;
  Ros2State by = Ros2State::kUnknown;  // the state while its callback runs
  Ros2State to = Ros2State::kUnknown;

  friend bool operator==(const Ros2Transition&, const Ros2Transition&) = default;
};

// The first transition towards `goal`. Nothing when it is reached, or cannot be reached: from
// finalized, from a transition state. Finalized is reached by cleanup and then shutdown.
std::optional<Ros2Transition> NextTransition(Ros2State from, Ros2State goal);

// In which primary state a node has to be for `state`: what `configured` says, else active for
// Active, finalized for TearDown, inactive for everything else.
Ros2State Ros2GoalOf(const std::map<State, Ros2State>& configured, std::string_view state);

}  // namespace musher
