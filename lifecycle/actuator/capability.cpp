#include "musher/lifecycle/actuator/capability.hpp"

#include <algorithm>

namespace musher {
namespace {

bool RunsIn(const CapabilityConfig* declared, std::string_view state) {
  return declared == nullptr ? state == kActive : declared->RunsIn(state);
}

// "Active only", "Active and Protected", "Active, Protected and LowPower".
std::string Places(const CapabilityConfig* declared) {
  if (declared == nullptr) return std::string(kActive) + " only";
  const std::vector<State>& states = declared->states;
  if (states.size() == 1) return states.front() + " only";
  std::string places;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (i > 0) places += i + 1 == states.size() ? " and " : ", ";
    places += states[i];
  }
  return places;
}

Error RefuseState(const CapabilityConfig* declared, std::string_view capability,
                  const CapabilityView& view, ModuleCode module) {
  const std::string_view place = RunsIn(declared, view.state) ? view.target : view.state;
  const bool spared = place == kProtected && RunsIn(declared, kActive);
  std::string now = "is in " + std::string(view.state);
  if (!view.target.empty()) {
    now = "is switching from " + std::string(view.state) + " to " + std::string(view.target);
  }
  return {MakeCode(module, spared ? KeyCode::kProtectedError : KeyCode::kStateInvalid),
          std::string(capability) + " runs in " + Places(declared) + "; " +
              std::string(view.actuator) + " " + now};
}

Result<> EvaluateBattery(const CapabilityConfig& declared, std::optional<int> battery,
                         ModuleCode module) {
  if (!declared.min_battery || (battery && *battery >= *declared.min_battery)) return Ok();
  const std::string found =
      battery ? "it has " + std::to_string(*battery) + " %" : "its level is not known";
  return Error{MakeCode(module, KeyCode::kProtectedError),
               declared.name + " needs at least " + std::to_string(*declared.min_battery) +
                   " % of the battery; " + found};
}

// Why the actuator cannot be evaluated; empty where it is present.
std::string Absence(const ActuatorConfig& actuator, const ActuatorRecord& record) {
  if (record.presence == Presence::kPresent) return {};
  return actuator.name + " is " + std::string(PresenceName(record.presence));
}

CapabilityVerdict EvaluateOne(const MachineConfig& config, const Machine& machine,
                              const CapabilityConfig& declared, std::optional<int> battery) {
  CapabilityVerdict verdict{declared.name, true, kCodeOk, ""};
  for (const std::string& name : declared.actuators) {
    const ActuatorIndex i = *config.IndexOf(name);
    const ActuatorRecord& record = machine.actuators[i];
    std::string trouble;
    if (const auto fault = TroubleOf(record)) {
      trouble = name + " is degraded";
      if (!fault->message.empty()) trouble += ": " + fault->message;
    }
    Result<> allowed =
        EvaluateCapability(config, declared.name,
                           {name, record.report.state, record.report.target,
                            record.report.emergency_stop != 0 || machine.emergency.stop.has_value(),
                            battery, record.report.held_by_stop});
    if (const std::string absence = Absence(config.actuators[i], record); !absence.empty()) {
      allowed = Error{kCodeStateInvalid, absence};
    }
    if (!allowed) {
      return {declared.name, false, allowed.error().code,
              allowed.error().message + (trouble.empty() ? "" : "; " + trouble)};
    }
    if (!trouble.empty()) verdict.reason += (verdict.reason.empty() ? "" : "; ") + trouble;
  }
  return verdict;
}

}  // namespace

Result<> EvaluateCapability(const MachineConfig& config, std::string_view capability,
                            const CapabilityView& view, ModuleCode module) {
  const CapabilityConfig* declared = config.CapabilityOf(capability);
  if (declared != nullptr && !declared->Takes(view.actuator)) {
    return Error{MakeCode(module, KeyCode::kStateInvalid),
                 std::string(capability) + " is not declared for " + std::string(view.actuator)};
  }
  if (view.emergency_stop) {
    return Error{MakeCode(module, KeyCode::kStateInvalid),
                 "an emergency stop is engaged; until it is released " + std::string(capability) +
                     " does not run"};
  }
  if (view.held_by_stop) {
    return Error{MakeCode(module, KeyCode::kStateInvalid),
                 std::string(view.actuator) +
                     " is held by the emergency stop that was released; `musher set " +
                     std::string(view.state) + "` ends that"};
  }
  const bool runs =
      RunsIn(declared, view.state) && (view.target.empty() || RunsIn(declared, view.target));
  if (!runs) return RefuseState(declared, capability, view, module);
  return declared == nullptr ? Ok() : EvaluateBattery(*declared, view.battery, module);
}

std::vector<CapabilityVerdict> EvaluateCapabilities(const MachineConfig& config,
                                                    const Machine& machine,
                                                    std::optional<int> battery) {
  std::vector<CapabilityVerdict> verdicts;
  verdicts.reserve(config.capabilities.size());
  for (const CapabilityConfig& declared : config.capabilities) {
    verdicts.push_back(EvaluateOne(config, machine, declared, battery));
  }
  return verdicts;
}

}  // namespace musher
