#include "musher/lifecycle/config/flow.hpp"

#include <algorithm>

#include "musher/lifecycle/config/ros2_states.hpp"

namespace musher {

bool FlowAllows(const MachineConfig& config, std::string_view from, std::string_view to) {
  if (!config.HasState(to) || to == kSetUp || to == kUninitialized) return false;
  if (from == kTearDown) return false;  // only a new start leaves it
  if (from == to || to == kTearDown) return true;
  if (to == kSelfCheck) return from != kUninitialized;
  if (from == kSelfCheck && (to == kActive || to == kDeActive || to == kError)) return true;
  return std::any_of(config.flow.begin(), config.flow.end(),
                     [&](const FlowEdge& edge) { return edge.from == from && edge.to == to; });
}

bool Rises(const MachineConfig& config, std::string_view from, std::string_view to) {
  const auto rank = config.RankOf(to);
  return rank && *rank > config.RankOf(from).value_or(*BuiltInRank(kDeActive));
}

bool Falls(const MachineConfig& config, std::string_view from, std::string_view to) {
  const auto own = config.RankOf(from);
  const auto rank = config.RankOf(to);
  return own && rank && *rank < *own;
}

bool SwitchesOnAgain(const MachineConfig& config, std::string_view from, std::string_view to) {
  return !Falls(config, from, to) && Rises(config, kUninitialized, to);
}

bool MaySwitchOn(const MachineConfig& config, std::string_view from, std::string_view to) {
  return Rises(config, from, to) || (from != to && SwitchesOnAgain(config, from, to));
}

bool RunsCallback(const MachineConfig& config, ActuatorIndex actuator, std::string_view from,
                  std::string_view to) {
  const ActuatorConfig& own = config.actuators[actuator];
  const bool configures = from == config.default_state;
  return own.protocol != Protocol::kRos2Lifecycle || configures ||
         Ros2GoalOf(own.ros2_states, from) != Ros2GoalOf(own.ros2_states, to);
}

std::vector<State> Reachable(const MachineConfig& config, std::string_view from) {
  std::vector<State> reachable;
  for (const State& to : config.states) {
    if (to != from && FlowAllows(config, from, to)) reachable.push_back(to);
  }
  return reachable;
}

}  // namespace musher
