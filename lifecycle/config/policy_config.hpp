#pragma once
// The manager's rules as data, from [policy.*] of the state config. A missing table switches its
// rule off.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/time.hpp"

namespace musher {

// [policy.battery]: how active the machine may be at most. Levels in percent, inclusive.
struct BatteryPolicy {
  std::string topic = "bms_status";            // protocol/BmsStatus
  int protected_at = 20;                       // at most Protected
  int low_power_at = 5;                        // at most LowPower, unless it is being charged
  int tear_down_at = 0;                        // TearDown and off, unless it is being charged
  int hysteresis = 2;                          // a ceiling is lifted this far above its level
  Duration silent = std::chrono::seconds(10);  // without a sample this long: a warning

  friend bool operator==(const BatteryPolicy&, const BatteryPolicy&) = default;
};

// [policy.low_power]: a robot that lies still goes to LowPower.
struct LowPowerPolicy {
  std::string topic = "motion_status";              // protocol/MotionStatus
  std::vector<std::int32_t> motion_ids = {0, 101};  // lying, and lying down
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

// The occasions on which the manager speaks.
enum class Occasion {
  kStart,    // the robot is ready, and which parts are not
  kBattery,  // it is low
  kTouch,    // a double tap queries the charge
  kSwitch,   // a switch was refused, undone or done-degraded
  kRefusal,  // the policy refuses something, or warns
  kApp,      // the app connects for the first time; the robot also stands up
};
inline constexpr std::array<std::pair<std::string_view, Occasion>, 6> kOccasions = {{
    {"start", Occasion::kStart},
    {"battery", Occasion::kBattery},
    {"touch", Occasion::kTouch},
    {"switch", Occasion::kSwitch},
    {"refusal", Occasion::kRefusal},
    {"app", Occasion::kApp},
}};

// [policy.voice], used with policy.manager.
struct VoicePolicy {
  std::vector<Occasion> say = {Occasion::kStart,  Occasion::kBattery, Occasion::kTouch,
                               Occasion::kSwitch, Occasion::kRefusal, Occasion::kApp};
  int battery_at = 30;        // %: at or below it the first announcement of the battery
  bool quiet_asleep = false;  // in LowPower the manager speaks only when the robot is touched

  bool Announces(Occasion occasion) const {
    return std::find(say.begin(), say.end(), occasion) != say.end();
  }
  friend bool operator==(const VoicePolicy&, const VoicePolicy&) = default;
};

struct PolicyConfig {
  bool manager = false;  // an extension of the controller serves a manager's interfaces
  std::optional<BatteryPolicy> battery;
  std::optional<LowPowerPolicy> low_power;
  PowerPolicy power;
  VoicePolicy voice;

  friend bool operator==(const PolicyConfig&, const PolicyConfig&) = default;
};

}  // namespace musher
