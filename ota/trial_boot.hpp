#pragma once
// Evaluates a trial boot from the machine, after each of its steps. Pure.

#include <optional>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher::ota {

// Ok: every stage is up and every critical actuator is well. An Error: why that is no longer
// possible. nullopt: undecided, or the machine is being taken down.
//
// `held`: the start-up was refused because of an emergency stop, which says nothing of the version.
// Such a machine is undecided until it is up, or a critical actuator has a fault.
//
// An actuator that is not critical may fail; it is listed as degraded, as in any start.
std::optional<Result<>> EvaluateTrialBoot(const MachineConfig& config, const Machine& machine,
                                          bool held = false);

}  // namespace musher::ota
