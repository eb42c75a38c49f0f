#pragma once
// Whether a new version has proved itself: judged from the machine, after each of its steps. Pure.

#include <optional>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::ota {

// Ok: every stage has come up and every critical actuator is well. An Error: it cannot come to that
// any more, and why. nullopt: it is not known yet, or the machine is being taken down.
//
// An actuator that is not critical may fail; it is listed as degraded, as in any start.
std::optional<Result<>> EvaluateTrialBoot(const MachineConfig& config, const Machine& machine);

}  // namespace musher::ota
