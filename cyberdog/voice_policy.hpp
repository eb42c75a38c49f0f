#pragma once
// [policy.voice] of the state config, and what else CyberDog's manager adds to [policy]: the
// motions of a robot that lies, and time to announce an empty battery. A program that includes this
// header reads it (lifecycle/config/toml/manager_policy.hpp).

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/lifecycle/config/policy_config.hpp"
#include "musher/lifecycle/config/toml/manager_policy.hpp"

namespace musher::cyberdog {

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

// Default of low_power.motion_ids: lying, and lying down.
inline constexpr std::array<std::int32_t, 2> kLyingMotions = {0, 101};

class VoicePolicy : public ManagerPolicy {
 public:
  std::vector<Occasion> say = {Occasion::kStart,  Occasion::kBattery, Occasion::kTouch,
                               Occasion::kSwitch, Occasion::kRefusal, Occasion::kApp};
  int battery_at = 30;        // %: at or below it the first announcement of the battery
  bool quiet_asleep = false;  // in LowPower the manager speaks only when the robot is touched

  bool Announces(Occasion occasion) const;
  std::vector<Key> Keys() const override;

  friend bool operator==(const VoicePolicy& one, const VoicePolicy& other) {
    return one.say == other.say && one.battery_at == other.battery_at &&
           one.quiet_asleep == other.quiet_asleep;
  }
};

// Completes the policy with `voice` and the manager's defaults, as reading [policy.voice] does.
// `policy.manager` and the times of `policy.power` are set before.
void CompletePolicy(const VoicePolicy& voice, PolicyConfig& policy);

// The defaults, if the config has no [policy.voice].
const VoicePolicy& VoiceOf(const PolicyConfig& policy);

void ReadVoicePolicy(config_toml::TableReader& table, PolicyConfig& policy);

inline const bool kVoicePolicyIsRead = config_toml::RegisterManagerPolicyReader(ReadVoicePolicy);

}  // namespace musher::cyberdog
