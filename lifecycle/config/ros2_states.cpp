#include "musher/lifecycle/config/ros2_states.hpp"

namespace musher {
namespace {

using S = Ros2State;

constexpr Ros2Transition kConfigure{1, "configure", S::kUnconfigured, S::kConfiguring,
                                    S::kInactive};
constexpr Ros2Transition kCleanup{2, "cleanup", S::kInactive, S::kCleaningUp, S::kUnconfigured};
constexpr Ros2Transition kActivate{3, "activate", S::kInactive, S::kActivating, S::kActive};
constexpr Ros2Transition kDeactivate{4, "deactivate", S::kActive, S::kDeactivating, S::kInactive};
constexpr Ros2Transition kShutdown{5, "shutdown", S::kUnconfigured, S::kShuttingDown,
                                   S::kFinalized};

}  // namespace

std::string_view Ros2StateName(Ros2State state) {
  switch (state) {
    case S::kUnconfigured:
      return "unconfigured";
    case S::kInactive:
      return "inactive";
    case S::kActive:
      return "active";
    case S::kFinalized:
      return "finalized";
    case S::kConfiguring:
      return "configuring";
    case S::kCleaningUp:
      return "cleaning up";
    case S::kShuttingDown:
      return "shutting down";
    case S::kActivating:
      return "activating";
    case S::kDeactivating:
      return "deactivating";
    case S::kErrorProcessing:
      return "error processing";
    case S::kUnknown:
      break;
  }
  return "unknown";
}

bool IsPrimary(Ros2State state) {
  return state == S::kUnconfigured || state == S::kInactive || state == S::kActive ||
         state == S::kFinalized;
}

std::optional<Ros2Transition> NextTransition(Ros2State from, Ros2State goal) {
  if (from == goal || !IsPrimary(goal)) return std::nullopt;
  switch (from) {
    case S::kUnconfigured:
      return goal == S::kFinalized ? kShutdown : kConfigure;
    case S::kInactive:
      return goal == S::kActive ? kActivate : kCleanup;
    case S::kActive:
      return kDeactivate;
    default:
      return std::nullopt;
  }
}

Ros2State Ros2GoalOf(const std::map<State, Ros2State>& configured, std::string_view state) {
  const auto own = configured.find(State(state));
  if (own != configured.end()) return own->second;
  if (state == kActive) return S::kActive;
  return state == kTearDown ? S::kFinalized : S::kInactive;
}

}  // namespace musher
