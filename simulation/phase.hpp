#pragma once
// The phases of a machine, by which the coverage of injected events is counted.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "musher/lifecycle/machine/machine.hpp"

namespace musher::simulation {

enum class MachinePhase : std::uint8_t {
  kNoController,  // no controller leads
  kSettingUp,     // its processes start
  kAtRest,
  kJoining,      // an actuator is switched to the machine's state by itself
  kSent,         // a switch has begun, no actuator has replied
  kPartlyDone,   // some actuators have replied
  kOverdue,      // an actuator is overdue, and the controller queries it
  kRollingBack,  // a switch up has failed and is undone
  kFallingBack,  // to on_lost
  kStopped,      // at rest during an emergency stop
  kTearingDown,
  kOver,  // torn down, or the start has failed
};
inline constexpr std::size_t kMachinePhases = 12;

std::string_view MachinePhaseName(MachinePhase phase);  // "at rest", "partly done", …

// null: no controller leads.
MachinePhase MachinePhaseOf(const Machine* machine);

}  // namespace musher::simulation
