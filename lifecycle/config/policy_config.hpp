#pragma once
// The manager's rules as data, from [policy.*] of the state config. A missing table switches its
// rule off.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/manager_policy.hpp"

namespace musher {

// [policy.battery]: how active the machine may be at most. Levels in percent, inclusive.
struct BatteryPolicy {
  std::string topic = "bms_status";            // protocol/BmsStatus
  int protected_at = 20;                       // at most Protected
  int low_power_at = 5;                        // at most LowPower, unless it is being charged
  int tear_down_at = 0;                        // TearDown and off, unless it is being charged
  int hysteresis = 2;                          // a ceiling is lifted this far above its level
  Duration silent = std::chrono::seconds(10);  // without a sample this long: a warning
  // Both by the steady clock: a jump of /clock confirms nothing.
  Duration tear_down_after = std::chrono::seconds(3);  // all samples this long report it empty
  Duration raise_after = std::chrono::seconds(5);  // no sample this long is below the next ceiling

  friend bool operator==(const BatteryPolicy&, const BatteryPolicy&) = default;
};

// [policy.low_power]: a robot that lies still goes to LowPower.
struct LowPowerPolicy {
  std::string topic = "motion_status";  // protocol/MotionStatus
  // The motions of a robot that lies. Empty: not given, and no manager has a default, with which no
  // controller starts.
  std::vector<std::int32_t> motion_ids;
  Duration lying_still = std::chrono::seconds(30);
  bool enabled = false;  // the switch, until another value is stored

  friend bool operator==(const LowPowerPolicy&, const LowPowerPolicy&) = default;
};

// [policy.power_off] and [policy.reboot].
struct PowerPolicy {
  Duration delay = std::chrono::seconds(2);         // from the answer to TearDown
  Duration force_after = std::chrono::seconds(15);  // from the answer to the command, regardless
  std::vector<std::string> off_command;             // argv; empty: nothing is run
  std::vector<std::string> reboot_command;

  friend bool operator==(const PowerPolicy&, const PowerPolicy&) = default;
};

// [policy].
struct PolicyConfig {
  bool manager = false;  // an extension of the controller serves a manager's interfaces
  std::optional<BatteryPolicy> battery;
  std::optional<LowPowerPolicy> low_power;
  PowerPolicy power;
  SharedManagerPolicy manager_policy;    // of the manager's own tables
  std::vector<std::string> unread_keys;  // "policy.voice": of a manager that this program lacks
  Duration empty_battery_delay{};        // before TearDown, for the manager to announce it

  friend bool operator==(const PolicyConfig&, const PolicyConfig&) = default;
};

}  // namespace musher
