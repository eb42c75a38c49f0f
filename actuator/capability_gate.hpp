#pragma once
// Decides on any thread whether a function of an actuator may run now, from the last values that
// the loop has set.

#include <mutex>
#include <optional>
#include <string_view>

#include "musher/lifecycle/actuator/capability.hpp"
#include "musher/lifecycle/machine/report.hpp"

namespace musher {

class CapabilityGate {
 public:
  void SetReport(const ActuatorReport& report);
  void SetBattery(std::optional<int> percent);  // nullopt: unknown

  State state() const;
  bool emergency_stop() const;
  bool held_by_stop() const;
  Result<> Evaluate(const MachineConfig& config, std::string_view actuator,
                    std::string_view capability, ModuleCode module) const;

 private:
  mutable std::mutex mutex_;  // guards the members below
  State state_{kUninitialized};
  State target_;
  bool emergency_stop_ = false;
  bool held_by_stop_ = false;
  std::optional<int> battery_;
};

}  // namespace musher
