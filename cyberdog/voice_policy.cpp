#include "musher/cyberdog/voice_policy.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "musher/base/toml/rows.hpp"

namespace musher::cyberdog {
namespace {

namespace row = config_toml::row;

void ReadSay(config_toml::TableReader& keys, VoicePolicy& voice) {
  auto say =
      keys.Choices<Occasion>("say", {kOccasions.begin(), kOccasions.end()}, {.may_be_empty = true});
  if (!say) return;
  voice.say = std::move(*say);
  std::sort(voice.say.begin(), voice.say.end());  // their order has no meaning
}

const VoicePolicy& Defaults() {
  static const VoicePolicy defaults;
  return defaults;
}

}  // namespace

bool VoicePolicy::Announces(Occasion occasion) const {
  return std::find(say.begin(), say.end(), occasion) != say.end();
}

std::vector<ManagerPolicy::Key> VoicePolicy::Keys() const {
  if (*this == Defaults()) return {};
  Key occasions{"policy.voice", "say", {}, true};
  for (const auto& [name, occasion] : kOccasions) {
    if (Announces(occasion)) occasions.values.emplace_back(name);
  }
  return {occasions,
          {"policy.voice", "battery_at", {std::to_string(battery_at) + " %"}},
          {"policy.voice", "quiet_asleep", {quiet_asleep ? "true" : "false"}}};
}

void CompletePolicy(const VoicePolicy& voice, PolicyConfig& policy) {
  policy.manager_policy = SharedManagerPolicy(std::make_shared<const VoicePolicy>(voice));
  const bool announced = policy.manager && voice.Announces(Occasion::kBattery);
  policy.empty_battery_delay = announced ? policy.power.delay : Duration{};
  if (policy.low_power && policy.low_power->motion_ids.empty()) {
    policy.low_power->motion_ids.assign(kLyingMotions.begin(), kLyingMotions.end());
  }
}

const VoicePolicy& VoiceOf(const PolicyConfig& policy) {
  const auto* voice = dynamic_cast<const VoicePolicy*>(policy.manager_policy.get());
  return voice == nullptr ? Defaults() : *voice;
}

void ReadVoicePolicy(config_toml::TableReader& table, PolicyConfig& policy) {
  VoicePolicy voice;
  if (auto reader = table.Sub("voice")) {
    ReadRows(*reader, {[&](config_toml::TableReader& keys) { ReadSay(keys, voice); },
                       row::Integer("battery_at", voice.battery_at, 0, 100, " (percent)"),
                       row::Bool("quiet_asleep", voice.quiet_asleep)});
    if (!policy.manager) {
      table.Warn(reader->at(), "voice", "has no effect: only policy.manager speaks");
    }
  }
  CompletePolicy(voice, policy);
}

}  // namespace musher::cyberdog
