#include "musher/controller/cyberdog/self_check.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace musher::cyberdog {
namespace {

using Json = nlohmann::ordered_json;
using Status = msg::SelfCheckStatus;

constexpr std::int32_t kNotKnown = -1;

std::int32_t CodeOf(const MachineConfig& config, const Machine& machine, std::string_view name) {
  const auto i = config.IndexOf(name);
  if (!i) return kNotKnown;
  const ActuatorRecord& record = machine.actuators[*i];
  if (record.fault) return record.fault->code;
  const bool passed = record.checked || config.RankOf(record.report.state).has_value();
  return record.presence == Presence::kPresent && passed ? kCodeOk : kNotKnown;
}

struct Part {
  const char* name;
  std::int32_t code;  // when it has failed
};

// One actuator for several parts: its code is that of a part, or the sum of several, as CyberDog's
// modules add them up. What is none of these is some other trouble.
Json Parts(std::int32_t code, const std::vector<Part>& parts,
           const std::vector<const char*>& more) {
  const unsigned subsets = 1U << parts.size();
  const auto sum_of = [&](unsigned subset) {
    std::int32_t sum = 0;
    for (std::size_t i = 0; i < parts.size(); ++i)
      sum += (subset >> i & 1U) != 0 ? parts[i].code : 0;
    return sum;
  };
  unsigned failed = 0;
  while (failed < subsets && sum_of(failed) != code) ++failed;
  const bool told = failed < subsets;  // also that all are well
  Json json;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool bad = told && (failed >> i & 1U) != 0;
    json[parts[i].name] = bad ? parts[i].code : told ? kCodeOk : kNotKnown;
  }
  for (const char* name : more) json[name] = kNotKnown;
  json["others"] = told ? kCodeOk : code;
  return json;
}

std::string Describe(const MachineConfig& config, const Machine& machine) {
  const auto code = [&](std::string_view name) { return CodeOf(config, machine, name); };
  constexpr const char* kOwnKeys[] = {"audio", "motion_manager", "algorithm_manager", "vp_engine",
                                      "RealSenseActuator"};
  Json json;
  for (const char* name : kOwnKeys) json[name] = code(name);
  json["device"] =
      Parts(code("device_manager"), {{"bms", 1409}, {"led", 1109}, {"touch", 1509}, {"uwb", 1609}},
            {"bluetooth"});
  json["sensor"] = Parts(code("sensor_manager"), {{"lidar", 2109}, {"tof", 2209}}, {});
  for (const ActuatorConfig& actuator : config.actuators) {
    const bool told = json.contains(actuator.name) || actuator.name == "device_manager" ||
                      actuator.name == "sensor_manager";
    if (!told) json[actuator.name] = code(actuator.name);
  }
  return json.dump();
}

std::int32_t Progress(const Machine& machine) {
  const auto& all = machine.actuators;
  const bool well = std::none_of(all.begin(), all.end(),
                                 [](const ActuatorRecord& r) { return r.fault.has_value(); });
  switch (machine.phase) {
    case Phase::kStarting:
      return Status::kChecking;
    case Phase::kFailed:
      return Status::kCriticalFailed;
    case Phase::kRunning:
      if (machine.policy.loaded) return well ? Status::kAllFine : Status::kFailedStarted;
      return well ? Status::kFineStarting : Status::kFailedStarting;
    default:
      return Status::kUnknown;
  }
}

}  // namespace

msg::SelfCheckStatus SelfCheckOf(const MachineConfig& config, const Machine& machine) {
  return {Progress(machine), Describe(config, machine)};
}

}  // namespace musher::cyberdog
