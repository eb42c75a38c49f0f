#pragma once
// What a machine is doing, for the judgement of what can strike it when.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "musher/lifecycle/machine.hpp"

namespace musher::simulation {

// What the machine is doing.
enum class MachinePhase : std::uint8_t {
  kNoController,  // nobody leads
  kSettingUp,     // its processes come up
  kAtRest,
  kJoining,      // one actuator is on its own way to where the machine is
  kSent,         // a switch has begun, nobody has answered
  kHalfWay,      // some have answered
  kAsking,       // one is overdue
  kRollingBack,  // a switch up has failed
  kFallingBack,  // to on_lost
  kStopped,      // by an emergency stop, at rest
  kTearingDown,
  kOver,  // torn down, or the start has failed
};
inline constexpr std::size_t kMachinePhases = 12;

std::string_view MachinePhaseName(MachinePhase phase);  // "at rest", "half way", …

// null: nobody leads.
MachinePhase MachinePhaseOf(const Machine* machine);

}  // namespace musher::simulation
