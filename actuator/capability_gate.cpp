#include "musher/actuator/capability_gate.hpp"

namespace musher {

void CapabilityGate::SetReport(const ActuatorReport& report) {
  const std::lock_guard lock(mutex_);
  state_ = report.state;
  target_ = report.target;
  emergency_stop_ = report.emergency_stop != 0;
  held_by_stop_ = report.held_by_stop;
}

void CapabilityGate::SetBattery(std::optional<int> percent) {
  const std::lock_guard lock(mutex_);
  battery_ = percent;
}

State CapabilityGate::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

bool CapabilityGate::emergency_stop() const {
  const std::lock_guard lock(mutex_);
  return emergency_stop_;
}

bool CapabilityGate::held_by_stop() const {
  const std::lock_guard lock(mutex_);
  return held_by_stop_;
}

Result<> CapabilityGate::Evaluate(const MachineConfig& config, std::string_view actuator,
                                  std::string_view capability, ModuleCode module) const {
  const std::lock_guard lock(mutex_);
  return EvaluateCapability(config, capability,
                            {actuator, state_, target_, emergency_stop_, battery_, held_by_stop_},
                            module);
}

}  // namespace musher
