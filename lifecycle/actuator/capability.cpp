#include "musher/lifecycle/actuator/capability.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/refusal.hpp"

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

// With the code of the actuator's own module.
Error WithModule(ModuleCode module, Error refusal) {
  const auto key =
      static_cast<KeyCode>(refusal.code - static_cast<std::int32_t>(ModuleCode::kRobot));
  return {MakeCode(module, key), std::move(refusal.message)};
}

Error RefuseState(const CapabilityConfig* declared, std::string_view capability,
                  const CapabilityView& view, ModuleCode module) {
  const std::string_view place = RunsIn(declared, view.state) ? view.target : view.state;
  const bool spared = place == kProtected && RunsIn(declared, kActive);
  Error refusal = view.target.empty()
                      ? Refused<Refusal::kNotInThisState>(capability, Places(declared),
                                                          view.actuator, view.state)
                      : Refused<Refusal::kNotWhileSwitching>(
                            capability, Places(declared), view.actuator, view.state, view.target);
  if (spared) refusal.code = kCodeProtectedError;
  return WithModule(module, std::move(refusal));
}

Result<> EvaluateBattery(const CapabilityConfig& declared, std::optional<int> battery,
                         ModuleCode module) {
  if (!declared.min_battery || (battery && *battery >= *declared.min_battery)) return Ok();
  const int least = *declared.min_battery;
  return WithModule(module, battery
                                ? Refused<Refusal::kBatteryTooLow>(declared.name, least, *battery)
                                : Refused<Refusal::kBatteryUnknown>(declared.name, least));
}

// Why the actuator cannot be evaluated; empty where it is present.
std::string Absence(const ActuatorConfig& actuator, const KnownActuator& known) {
  if (known.presence == Presence::kPresent) return {};
  return actuator.name + " is " + std::string(PresenceName(known.presence));
}

CapabilityVerdict EvaluateOne(const MachineConfig& config, const Machine& machine,
                              const CapabilityConfig& declared, std::optional<int> battery) {
  CapabilityVerdict verdict{declared.name, true, kCodeOk, ""};
  for (const std::string& name : declared.actuators) {
    const ActuatorIndex i = *config.IndexOf(name);
    const KnownActuator& known = machine.actuators[i];
    std::string trouble;
    if (const auto fault = TroubleOf(known)) {
      trouble = name + " is degraded";
      if (!fault->message.empty()) trouble += ": " + fault->message;
    }
    Result<> allowed =
        EvaluateCapability(config, declared.name,
                           {name, known.report.state, known.report.target,
                            known.report.emergency_stop != 0 || machine.emergency.stop.has_value(),
                            battery, known.report.held_by_stop});
    if (const std::string absence = Absence(config.actuators[i], known); !absence.empty()) {
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
    return WithModule(module, Refused<Refusal::kNotDeclared>(capability, view.actuator));
  }
  if (view.emergency_stop) {
    return WithModule(module, Refused<Refusal::kStopForbidsCapability>(capability));
  }
  if (view.held_by_stop) {
    return WithModule(module, Refused<Refusal::kHeldByReleasedStop>(view.actuator, view.state));
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
