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
// An actuator that is not critical may fail; it is listed as degraded, as in any start.
std::optional<Result<>> EvaluateTrialBoot(const MachineConfig& config, const Machine& machine);

}  // namespace musher::ota
