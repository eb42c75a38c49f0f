#pragma once
// Whether a capability of the robot may run now, and why not: the rule that actuators enforce and
// the controller publishes. Pure.
//
// A capability runs in the states that its [capability.<name>] lists; without such a table, in
// Active only. While a callback runs, it has to be allowed both in the state that is left and in
// the state that is entered. No capability runs while an emergency stop is engaged.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

// The inputs of the rule at one actuator, at one instant.
struct CapabilityView {
  std::string_view actuator;
  std::string_view state;
  std::string_view target;  // its callback runs for this state; empty when it is free
  bool emergency_stop = false;
  std::optional<int> battery;  // %; nullopt: unknown
  bool held_by_stop = false;   // what a stop has switched off is still off, see ActuatorReport
};

// Whether the actuator may run the capability. The Error has the code of `module`: ProtectedError
// where the robot is being protected (the capability runs in Active but not in Protected, or the
// battery is too low or unknown), else StateInvalid. Where it may run, nothing is allocated.
Result<> EvaluateCapability(const MachineConfig& config, std::string_view capability,
                            const CapabilityView& view, ModuleCode module = ModuleCode::kRobot);

// What is published of one capability.
struct CapabilityVerdict {
  std::string name;
  bool allowed = false;
  std::int32_t code = kCodeOk;
  std::string reason;  // why not; where it is allowed, which of its actuators is degraded, and why

  friend bool operator==(const CapabilityVerdict&, const CapabilityVerdict&) = default;
};

// All capabilities that the config declares, in its order. A capability of several actuators is
// allowed when all of them allow it; the first refusal is given.
std::vector<CapabilityVerdict> EvaluateCapabilities(const MachineConfig& config,
                                                    const Machine& machine,
                                                    std::optional<int> battery);

}  // namespace musher
