#pragma once
// Whether the level of a battery counts whose driver may leave `present` of its messages false,
// which is the default of the field. It counts in doubt: once the driver reports two levels above
// 0, or a voltage that changes beside a level above 0. A driver that has said that its battery is
// present is believed when it says that it is not. Pure; threads: one at a time.

#include <cmath>
#include <optional>

namespace musher::skills {

class BatteryPresence {
 public:
  // Of each message. `share`: 0 to 1; `voltage_v`: not a number where it is not measured.
  bool Counts(bool present, double share, double voltage_v) {
    if (present) {
      says_it_ = true;
      return true;
    }
    if (says_it_) return false;
    const bool measured = std::isfinite(voltage_v) && voltage_v >= kLeastV;
    const bool level_changes = share > 0 && share_ && std::abs(share - *share_) > kShareChange;
    const bool voltage_changes =
        measured && voltage_v_ && share > 0 && std::abs(voltage_v - *voltage_v_) > kVoltageChangeV;
    changes_ = changes_ || level_changes || voltage_changes;
    if (!share_ && share > 0) share_ = share;
    if (measured && !voltage_v_) voltage_v_ = voltage_v;
    return changes_;
  }

 private:
  static constexpr double kShareChange = 0.001;
  static constexpr double kVoltageChangeV = 0.01;
  static constexpr double kLeastV = 1;  // an open input floats below it

  bool says_it_ = false;
  bool changes_ = false;
  std::optional<double> share_;  // the first ones that are measured
  std::optional<double> voltage_v_;
};

}  // namespace musher::skills
