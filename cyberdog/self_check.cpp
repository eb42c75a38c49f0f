#include "musher/cyberdog/self_check.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "musher/cyberdog/parts.hpp"

namespace musher::cyberdog {
namespace {

using OrderedJson = nlohmann::ordered_json;
using CheckStatus = msg::SelfCheckStatus;

constexpr std::int32_t kNotKnown = -1;

std::int32_t CodeOf(const MachineConfig& config, const Machine& machine, std::string_view name) {
  const auto i = config.IndexOf(name);
  if (!i) return kNotKnown;
  const KnownActuator& known = machine.actuators[*i];
  if (const auto trouble = TroubleOf(known)) return trouble->code;
  const bool passed = known.checked || config.RankOf(known.report.state).has_value();
  return known.presence == Presence::kPresent && passed ? kCodeOk : kNotKnown;
}

// An actuator with several parts. A code of no part is another fault.
OrderedJson Parts(const MachineConfig& config, const Machine& machine, std::string_view actuator,
                  const std::vector<const char*>& more = {}) {
  const std::int32_t code = CodeOf(config, machine, actuator);
  const auto parts = PartsOf(actuator);
  std::vector<std::int32_t> failed;
  if (code > kCodeOk)
    failed = FailedCodes(parts, *TroubleOf(machine.actuators[*config.IndexOf(actuator)]));
  const auto has_failed = [&](std::int32_t part) {
    return std::find(failed.begin(), failed.end(), part) != failed.end();
  };
  // With a fault of no part the state of the parts is unknown.
  const bool of_parts =
      code == kCodeOk || std::any_of(parts.begin(), parts.end(),
                                     [&](const Part& part) { return has_failed(part.code); });
  OrderedJson json;
  std::int32_t others = of_parts ? kCodeOk : code;
  for (const Part& part : parts) {
    if (part.own_key) {
      json[std::string(part.name)] = has_failed(part.code) ? part.code
                                     : of_parts            ? kCodeOk
                                                           : kNotKnown;
    } else if (has_failed(part.code) && others == kCodeOk) {
      others = part.code;
    }
  }
  for (const char* name : more) json[name] = kNotKnown;
  json["others"] = others;
  return json;
}

std::string Describe(const MachineConfig& config, const Machine& machine) {
  const auto code = [&](std::string_view name) { return CodeOf(config, machine, name); };
  constexpr const char* kOwnKeys[] = {"audio", "motion_manager", "algorithm_manager", "vp_engine",
                                      "RealSenseActuator"};
  OrderedJson json;
  for (const char* name : kOwnKeys) json[name] = code(name);
  json["device"] = Parts(config, machine, "device_manager", {"bluetooth"});
  json["sensor"] = Parts(config, machine, "sensor_manager");
  for (const ActuatorConfig& actuator : config.actuators) {
    const bool listed = json.contains(actuator.name) || actuator.name == "device_manager" ||
                        actuator.name == "sensor_manager";
    if (!listed) json[actuator.name] = code(actuator.name);
  }
  return json.dump();
}

std::int32_t Progress(const Machine& machine) {
  const auto& all = machine.actuators;
  const bool well = std::none_of(all.begin(), all.end(),
                                 [](const KnownActuator& r) { return TroubleOf(r).has_value(); });
  switch (machine.phase) {
    case Phase::kStarting:
      return CheckStatus::kChecking;
    case Phase::kFailed:
      return CheckStatus::kCriticalFailed;
    case Phase::kRunning:
      if (machine.policy.loaded) return well ? CheckStatus::kAllFine : CheckStatus::kFailedStarted;
      return well ? CheckStatus::kFineStarting : CheckStatus::kFailedStarting;
    default:
      return CheckStatus::kUnknown;
  }
}

}  // namespace

msg::SelfCheckStatus SelfCheckOf(const MachineConfig& config, const Machine& machine) {
  return {Progress(machine), Describe(config, machine)};
}

}  // namespace musher::cyberdog
