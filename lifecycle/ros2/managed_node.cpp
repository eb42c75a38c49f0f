#include "musher/lifecycle/ros2/managed_node.hpp"

#include <algorithm>
#include <array>

#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

using S = Ros2State;

constexpr std::array kAllRos2States = {S::kUnknown,      S::kUnconfigured,   S::kInactive,
                                       S::kActive,       S::kFinalized,      S::kConfiguring,
                                       S::kCleaningUp,   S::kShuttingDown,   S::kActivating,
                                       S::kDeactivating, S::kErrorProcessing};

constexpr std::string_view kSuccess = "transition_success";
constexpr std::string_view kFailure = "transition_failure";
constexpr std::string_view kErrorEnd = "transition_error";

constexpr std::array<Ros2Edge, 25> kGraph = {{
    {1, "configure", S::kUnconfigured, S::kConfiguring},
    {10, kSuccess, S::kConfiguring, S::kInactive},
    {11, kFailure, S::kConfiguring, S::kUnconfigured},
    {12, kErrorEnd, S::kConfiguring, S::kErrorProcessing},
    {2, "cleanup", S::kInactive, S::kCleaningUp},
    {20, kSuccess, S::kCleaningUp, S::kUnconfigured},
    {21, kFailure, S::kCleaningUp, S::kInactive},
    {22, kErrorEnd, S::kCleaningUp, S::kErrorProcessing},
    {3, "activate", S::kInactive, S::kActivating},
    {30, kSuccess, S::kActivating, S::kActive},
    {31, kFailure, S::kActivating, S::kInactive},
    {32, kErrorEnd, S::kActivating, S::kErrorProcessing},
    {4, "deactivate", S::kActive, S::kDeactivating},
    {40, kSuccess, S::kDeactivating, S::kInactive},
    {41, kFailure, S::kDeactivating, S::kActive},
    {42, kErrorEnd, S::kDeactivating, S::kErrorProcessing},
    {5, "shutdown", S::kUnconfigured, S::kShuttingDown},
    {6, "shutdown", S::kInactive, S::kShuttingDown},
    {7, "shutdown", S::kActive, S::kShuttingDown},
    {50, kSuccess, S::kShuttingDown, S::kFinalized},
    {51, kFailure, S::kShuttingDown, S::kFinalized},
    {52, kErrorEnd, S::kShuttingDown, S::kErrorProcessing},
    {60, kSuccess, S::kErrorProcessing, S::kUnconfigured},
    {61, kFailure, S::kErrorProcessing, S::kFinalized},
    {62, kErrorEnd, S::kErrorProcessing, S::kFinalized},
}};

constexpr Duration kRefusalPeriod = std::chrono::seconds(10);

S PrimaryOf(const State& state) {
  if (state == kUninitialized || state == kSetUp || state == kError) return S::kUnconfigured;
  return Ros2GoalOf({}, state);
}

// The transition state between two primary states.
S TransitionState(S from, S to) {
  if (from == to) return from;
  switch (to) {
    case S::kActive:
      return S::kActivating;
    case S::kFinalized:
      return S::kShuttingDown;
    case S::kInactive:
      return from == S::kActive ? S::kDeactivating : S::kConfiguring;
    default:
      return S::kErrorProcessing;
  }
}

// The state after a transition whose callback succeeds.
S EndOf(S transition_state) {
  const auto* const end = std::find_if(kGraph.begin(), kGraph.end(), [&](const Ros2Edge& edge) {
    return edge.start == transition_state && edge.label == kSuccess;
  });
  return end->goal;
}

bool IsRequestable(const Ros2Edge& edge) {
  return IsPrimary(edge.start);
}

// The highest state below Active in which an actuator, or the machine, may stay.
std::optional<State> RestOf(const std::vector<State>& states, const MachineConfig& machine) {
  std::optional<State> highest;
  for (const State& state : states) {
    const auto rank = machine.RankOf(state);
    if (state == kDeActive) return state;
    const bool rests = rank && PrimaryOf(state) == S::kInactive && state != kOta;
    if (rests && (!highest || *rank > *machine.RankOf(*highest))) highest = state;
  }
  return highest;
}

}  // namespace

std::span<const Ros2Edge> Ros2Graph() {
  return kGraph;
}

std::span<const Ros2State> Ros2States() {
  return kAllRos2States;
}

std::vector<Ros2Edge> RequestableIn(Ros2State state) {
  std::vector<Ros2Edge> edges;
  for (const Ros2Edge& edge : kGraph) {
    if (edge.start == state && IsRequestable(edge)) edges.push_back(edge);
  }
  return edges;
}

std::string_view Ros2StateLabel(Ros2State state) {
  switch (state) {
    case S::kCleaningUp:
      return "cleaningup";
    case S::kShuttingDown:
      return "shuttingdown";
    case S::kErrorProcessing:
      return "errorprocessing";
    default:
      return Ros2StateName(state);
  }
}

void ManagedNode::Observe(const State& state, const State& target) {
  const bool moved = state != state_ || !target.empty();
  state_ = state;
  target_ = target;
  if (moved && !under_way_) led_to_.reset();
}

Result<Ros2Transition> ManagedNode::Begin(std::uint8_t id, std::string_view label) {
  const S now = state();
  for (const Ros2Edge& edge : RequestableIn(now)) {
    const bool meant = label.empty() ? edge.id == id : edge.label == label;
    if (!meant) continue;
    under_way_ = Ros2Transition{edge.id, edge.label, now, edge.goal, EndOf(edge.goal)};
    before_ = state_;
    return *under_way_;
  }
  const auto* const known = std::find_if(kGraph.begin(), kGraph.end(), [&](const Ros2Edge& edge) {
    return IsRequestable(edge) && (label.empty() ? edge.id == id : edge.label == label);
  });
  if (known != kGraph.end()) return Refused<Refusal::kTransitionImpossible>(Ros2StateName(now));
  return Refused<Refusal::kUnknownTransition>(label.empty() ? std::to_string(id)
                                                            : std::string(label.substr(0, 64)));
}

void ManagedNode::End(bool success) {
  if (!under_way_) return;
  const Ros2Transition ended = *under_way_;
  under_way_.reset();
  if (success) {
    led_to_ = ended.to;
  } else {
    led_to_ = state_ == before_ ? std::optional(ended.from) : std::nullopt;
  }
}

Ros2State ManagedNode::state() const {
  if (under_way_) return under_way_->by;
  const S at = led_to_.value_or(PrimaryOf(state_));
  if (target_.empty()) return at;
  if (target_ == kSetUp) return S::kUnconfigured;
  // In the run phase a self-check does not change the state.
  if (target_ == kSelfCheck && at != S::kUnconfigured) return at;
  return TransitionState(at, PrimaryOf(target_));
}

std::optional<State> TargetOf(const Ros2Transition& transition, const ActuatorConfig& actuator,
                              const MachineConfig& machine) {
  switch (transition.to) {
    case S::kInactive:
      if (transition.from == S::kActive) return RestOf(actuator.states, machine);
      return actuator.Lists(kSelfCheck) ? State(kSelfCheck) : State();
    case S::kActive:
      if (!actuator.Lists(kActive)) return std::nullopt;
      return State(kActive);
    case S::kUnconfigured:
      return RestOf(actuator.states, machine).value_or(State());
    default:
      return actuator.Lists(kTearDown) ? State(kTearDown) : State();
  }
}

std::optional<State> TargetOf(const Ros2Transition& transition, const MachineConfig& machine) {
  const Ros2Config& ros2 = machine.ros2;
  const auto listed = [&](const State& state) {
    return machine.HasState(state) ? std::optional(state) : std::nullopt;
  };
  switch (transition.to) {
    case S::kInactive:
      if (transition.from != S::kActive) return listed(ros2.configure).value_or(State());
      if (auto state = listed(ros2.deactivate)) return state;
      return RestOf(machine.states, machine);
    case S::kActive:
      return listed(ros2.activate);
    case S::kUnconfigured:
      return listed(ros2.cleanup);
    default:
      return listed(ros2.shutdown);
  }
}

std::optional<std::string> RefusalLog::Refused(const std::string& what, Time now) {
  if (logged_at_ && now - *logged_at_ < kRefusalPeriod) {
    ++suppressed_;
    return std::nullopt;
  }
  std::string line = what;
  if (suppressed_ != 0)
    line += " (and " + std::to_string(suppressed_) + " more since the last message)";
  logged_at_ = now;
  suppressed_ = 0;
  return line;
}

}  // namespace musher
