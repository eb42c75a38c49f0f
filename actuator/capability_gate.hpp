#pragma once
// Whether a function of an actuator may run now: what the loop told last, judged for any thread.

#include <mutex>
#include <optional>
#include <string_view>

#include "musher/lifecycle/capability.hpp"
#include "musher/lifecycle/report.hpp"

namespace musher {

class CapabilityGate {
 public:
  void SetReport(const ActuatorReport& report);
  void SetBattery(std::optional<int> percent);  // nullopt: not known

  State state() const;
  bool emergency_stop() const;
  bool held_by_stop() const;
  Result<> Judge(const MachineConfig& config, std::string_view actuator,
                 std::string_view capability, ModuleCode module) const;

 private:
  mutable std::mutex mutex_;  // guards all below
  State state_{kUninitialized};
  State target_;
  bool emergency_stop_ = false;
  bool held_by_stop_ = false;
  std::optional<int> battery_;
};

}  // namespace musher
