#pragma once
// What a status of `musher status --json` says of the way that actuators are on.

#include <nlohmann/json.hpp>

namespace musher::testing {

// Every actuator is present and at rest, and in the machine's state if it may go up.
inline bool AllHaveArrived(const nlohmann::json& status) {
  for (const auto& actuator : status["actuators"]) {
    if (actuator["presence"] != "present" || actuator["target"] != "") return false;
    const bool may_go_up = !status["emergency_stop"]["engaged"].get<bool>();
    if (may_go_up && actuator["state"] != status["state"]) return false;
  }
  return status["target"] == "";
}

}  // namespace musher::testing
