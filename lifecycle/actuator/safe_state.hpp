#pragma once
// The state of an actuator that has lost its controller: `on_controller_lost` of the config.
//
// Pure; from any thread.

#include <optional>

#include "musher/lifecycle/actuator/actuator_core.hpp"

namespace musher {

// None: it stays where it is, as it is at or below that state.
inline std::optional<State> SafeState(const MachineConfig& config, ActuatorIndex index,
                                      const ActuatorCore& core) {
  const State& safe = config.actuators[index].on_controller_lost;
  const auto own = config.RankOf(core.report.state);
  const auto rank = config.RankOf(safe);
  if (!own || !rank || *rank >= *own) return std::nullopt;
  return safe;
}

}  // namespace musher
