#pragma once
// What the robot can do now, and why not: the one judgement that actuators enforce and the
// controller publishes. Pure.
//
// A capability runs in the states that its [capability.<name>] lists, one without such a table in
// Active only. While a callback runs it has to be allowed both in the state that is left and in the
// one that is entered. Nothing of this kind runs while an emergency stop is engaged.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/code.hpp"
#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher {

// What counts at one actuator, at one moment.
struct CapabilityView {
  std::string_view actuator;
  std::string_view state;
  std::string_view target;  // its callback is running for this state; empty when it is free
  bool emergency_stop = false;
  std::optional<int> battery;  // %; nullopt: not known
  bool held_by_stop = false;   // what a stop has switched off is off still, see ActuatorReport
};

// Whether the actuator may do it. The Error has the code of `module`: ProtectedError where the
// robot spares itself (the capability runs in Active but not in Protected, or the battery is too
// low or unknown), else StateInvalid. Where it may, nothing is allocated.
Result<> EvaluateCapability(const MachineConfig& config, std::string_view capability,
                            const CapabilityView& view, ModuleCode module = ModuleCode::kRobot);

// What is published of one capability.
struct CapabilityVerdict {
  std::string name;
  bool allowed = false;
  std::int32_t code = kCodeOk;
  std::string reason;  // why not; or, where it is allowed, what is wrong with an actuator of it

  friend bool operator==(const CapabilityVerdict&, const CapabilityVerdict&) = default;
};

// All that the config declares, in its order. One that takes several actuators is allowed when all
// of them allow it; of the refusals the first is told.
std::vector<CapabilityVerdict> EvaluateCapabilities(const MachineConfig& config,
                                                    const Machine& machine,
                                                    std::optional<int> battery);

}  // namespace musher
