#include "musher/lifecycle/machine/policy_state.hpp"

#include <algorithm>
#include <array>

namespace musher {

std::string_view LevelName(BatteryLevel level) {
  switch (level) {
    case BatteryLevel::kFree:
      return "free";
    case BatteryLevel::kProtected:
      return "protected";
    case BatteryLevel::kLowPower:
      return "low power";
    case BatteryLevel::kEmpty:
      break;
  }
  return "empty";
}

std::string_view RequestName(PolicyRequest request) {
  switch (request) {
    case PolicyRequest::kSwitch:
      return "switch";
    case PolicyRequest::kKeep:
      return "keep";
    case PolicyRequest::kOta:
      return "ota";
    case PolicyRequest::kLowPowerSwitch:
      return "low-power";
    case PolicyRequest::kLowPowerStore:
      return "low-power-store";
    case PolicyRequest::kWakeUp:
      return "wake-up";
    case PolicyRequest::kPowerOff:
      return "power-off";
    case PolicyRequest::kReboot:
      break;
  }
  return "reboot";
}

std::optional<PolicyRequest> RequestOf(std::string_view name) {
  constexpr std::array kAll = {PolicyRequest::kSwitch,        PolicyRequest::kKeep,
                               PolicyRequest::kOta,           PolicyRequest::kLowPowerSwitch,
                               PolicyRequest::kLowPowerStore, PolicyRequest::kWakeUp,
                               PolicyRequest::kPowerOff,      PolicyRequest::kReboot};
  const auto* found = std::find_if(kAll.begin(), kAll.end(), [&](PolicyRequest request) {
    return RequestName(request) == name;
  });
  if (found == kAll.end()) return std::nullopt;
  return *found;
}

bool WakesUp(PolicyRequest request, bool enable) {
  const bool low_power =
      request == PolicyRequest::kLowPowerSwitch || request == PolicyRequest::kLowPowerStore;
  return request == PolicyRequest::kWakeUp || (low_power && !enable);
}

Time PolicyNow(const MachineConfig& config, const PolicyState& policy, Time now) {
  return config.clock == ClockSource::kTopic ? policy.clock : now;
}

}  // namespace musher
