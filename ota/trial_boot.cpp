#include "musher/ota/trial_boot.hpp"

#include <algorithm>

#include "musher/base/code.hpp"

namespace musher::ota {
namespace {

// The actuator is in the machine's state, or has a fault.
bool Settled(const MachineConfig& config, const Machine& machine, ActuatorIndex actuator) {
  const KnownActuator& known = machine.actuators[actuator];
  if (known.fault || known.held) return true;
  if (known.presence != Presence::kPresent || known.report.busy() || known.command) return false;
  return known.state() == machine.state || !config.actuators[actuator].Lists(machine.state);
}

std::string Why(const MachineConfig& config, ActuatorIndex actuator, const Error& fault) {
  return "critical " + config.actuators[actuator].name + ": " + WithCode(fault.message, fault.code);
}

}  // namespace

void UnderStop::Note(const Machine& machine) {
  const bool stopped = machine.emergency.stop.has_value();
  start_refused |= stopped && machine.phase == Phase::kFailed;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    if (!machine.actuators[i].fault) {
      faults.erase(i);
    } else if (stopped) {
      faults.insert(i);
    }
  }
}

std::optional<Result<>> EvaluateTrialBoot(const MachineConfig& config, const Machine& machine,
                                          const UnderStop& stop) {
  if (machine.phase != Phase::kRunning && machine.phase != Phase::kFailed) return std::nullopt;
  bool settled = machine.phase == Phase::kRunning && !machine.current;
  bool from_stop = false;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const auto& fault = machine.actuators[i].fault;
    const bool coming_back = machine.actuators[i].restart.at.has_value();
    if (fault && config.actuators[i].critical && !coming_back) {
      if (!stop.faults.contains(i)) return Result<>(Error{fault->code, Why(config, i, *fault)});
      from_stop = true;
      continue;
    }
    settled = settled && !coming_back && Settled(config, machine, i);
  }
  if (from_stop) return std::nullopt;
  if (machine.phase == Phase::kFailed && stop.start_refused) return std::nullopt;
  if (machine.phase == Phase::kFailed) return Result<>(Error{kCodeFailed, "the start-up failed"});
  return settled ? std::optional(Ok()) : std::nullopt;
}

}  // namespace musher::ota
