#pragma once
// The manager's rules as data, from [policy.*] of the state config. A missing table switches its
// rule off.
//
// Each struct lists the keys of its table once, in the order of messages: Keys() calls a function
// of `of` for each, by the kind of its value. The reader (toml/policy.cpp) and the words of
// `musher diff` (cli/config/config_words.cpp) go through them; `self` may be const.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/manager_policy.hpp"

namespace musher {

inline constexpr double kShortestPolicyS = 0.1;

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

  template <class Self, class Kinds>
  static void Keys(Self& self, Kinds& of) {
    of.Topic("topic", self.topic);
    of.Percent("protected_at", self.protected_at);
    of.Percent("low_power_at", self.low_power_at);
    of.Percent("tear_down_at", self.tear_down_at);
    of.Percent("hysteresis", self.hysteresis);
    of.Seconds("silent_s", self.silent, kShortestPolicyS);
    of.Seconds("tear_down_after_s", self.tear_down_after, 0);
    of.Seconds("raise_after_s", self.raise_after, 0);
  }

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

  template <class Self, class Kinds>
  static void Keys(Self& self, Kinds& of) {
    of.Topic("topic", self.topic);
    of.Bool("enabled", self.enabled);
    of.Seconds("lying_still_s", self.lying_still, kShortestPolicyS);
    of.Set("motion_ids", self.motion_ids);
  }

  friend bool operator==(const LowPowerPolicy&, const LowPowerPolicy&) = default;
};

// [policy.power_off] and [policy.reboot].
struct PowerPolicy {
  Duration delay = std::chrono::seconds(2);         // from the answer to TearDown
  Duration force_after = std::chrono::seconds(15);  // from the answer to the command, regardless
  std::vector<std::string> off_command;             // argv; empty: nothing is run
  std::vector<std::string> reboot_command;

  template <class Self, class Kinds>
  static void OffKeys(Self& self, Kinds& of) {
    of.Seconds("delay_s", self.delay, 0);
    of.Seconds("force_after_s", self.force_after, 0);
    of.Program("command", self.off_command);
  }
  template <class Self, class Kinds>
  static void RebootKeys(Self& self, Kinds& of) {
    of.Program("command", self.reboot_command);
  }

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
