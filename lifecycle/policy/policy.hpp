#pragma once
// The pure functions of numbers that the rules of the manager use (battery, lying still, keep,
// power). The rules themselves are in rules/.
//
// The battery sets a ceiling, the most active state allowed. It depends on the present level, not
// on a crossing: whatever the percentage was before, the machine may be no more active than the
// present percentage allows. So a jump is handled, too.

#include <optional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

// The level of `percent`, coming from `before`. Protected and LowPower are left only `hysteresis`
// above their thresholds. Empty has none: it ends the machine, unless the battery is being charged.
BatteryLevel LevelAt(const BatteryPolicy& policy, int percent, BatteryLevel before);

// The rank that `level` allows at most; nullopt: any.
std::optional<Rank> CeilingRank(BatteryLevel level);

// The state for a machine under that ceiling: the most active of its states that the ceiling
// allows, at most Active, and without Error and OTA, which have another purpose. Empty: there is
// none.
State CeilingState(const MachineConfig& config, BatteryLevel level);

// The level that takes the machine down. It follows from the present samples; a stored level takes
// the machine down once the battery counts as silent: until then a sample may be on its way. While
// the robot is being charged, the machine is not taken below Protected.
BatteryLevel TakingDownLevel(const MachineConfig& config, const PolicyState& policy);

// When samples in a row have confirmed their level by time; nullopt: they are too few.
std::optional<Time> ConfirmedAt(const std::optional<LevelRun>& run, Duration after);

// "the battery is at 4 %, being charged", or without a sample, that it was low before
std::string BatteryText(const PolicyState& policy);

// Why nothing goes above the ceiling of `level`, with the numbers and what to do.
Error AboveCeiling(const MachineConfig& config, const PolicyState& policy, BatteryLevel level);

// The refusal of what a reboot or a power-off, which was requested before, does not permit.
Error AboutToEnd(const PowerDown& power);
// Why the policy refuses a switch of the machine to `target`, with what would change that. Down is
// always allowed.
std::optional<Error> RefusalByPolicy(const MachineConfig& config, const Machine& machine,
                                     const State& target);

}  // namespace musher
