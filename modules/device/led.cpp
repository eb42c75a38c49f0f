#include "musher/modules/device/led.hpp"

#include <algorithm>

#include "musher/base/check.hpp"
#include "musher/base/toml/findings.hpp"

namespace musher::device {
namespace {

using Request = msg::LedExecute::Request;
using msg::LedExecute;

struct Effects {
  std::uint8_t first;
  std::uint8_t last;
};

// Nothing: no such mode.
std::optional<Effects> LegalEffects(std::uint8_t target, std::uint8_t mode) {
  const bool mini = target == LedExecute::kMini;
  if (mode == LedExecute::kUserColor) {
    return mini ? Effects{LedExecute::kCircularBreath, LedExecute::kCircularRing}
                : Effects{LedExecute::kRgbOn, LedExecute::kTrailingRace};
  }
  if (mode == LedExecute::kPredefined) {
    return mini ? Effects{LedExecute::kMiniOff, LedExecute::kColorOneByOne}
                : Effects{LedExecute::kRgbOff, LedExecute::kYellowOneByOneFast};
  }
  return std::nullopt;
}

Error LedError(LedKey key, const std::string& what) {
  return {LedCode(key), what};
}

std::string Range(const Effects& effects) {
  return std::to_string(effects.first) + " to " + std::to_string(effects.last);
}

std::size_t FirstStored(const std::array<std::optional<Light>, kLedClients.size()>& stored) {
  const auto* const first =
      std::find_if(stored.begin(), stored.end(), [](const auto& light) { return light; });
  MUSHER_CHECK(first != stored.end());  // that of `system`
  return static_cast<std::size_t>(first - stored.begin());
}

}  // namespace

Light DefaultLight(std::uint8_t target) {
  const std::uint8_t effect =
      target == LedExecute::kMini ? LedExecute::kCircularBreath : LedExecute::kTrailingRace;
  return {LedExecute::kUserColor, effect, 6, 33, 226};
}

LedArbiter::LedArbiter() {
  for (std::size_t i = 0; i < kLedTargets.size(); ++i) {
    stored_[i].back() = DefaultLight(kLedTargets[i]);
  }
}

Result<> LedArbiter::Execute(const Request& request) {
  const auto* const target = std::find(kLedTargets.begin(), kLedTargets.end(), request.target);
  if (target == kLedTargets.end()) {
    return LedError(LedKey::kNoSuchTarget, "unknown target " + std::to_string(request.target) +
                                               "; 1 is the head, 2 the tail, 3 the mini light");
  }
  const auto* const client = std::find(kLedClients.begin(), kLedClients.end(), request.client);
  if (client == kLedClients.end()) {
    return LedError(LedKey::kNoSuchClient, "unknown client " + config_toml::Quote(request.client));
  }
  Stored& stored = stored_[static_cast<std::size_t>(target - kLedTargets.begin())];
  const auto index = static_cast<std::size_t>(client - kLedClients.begin());
  if (!request.occupation && *client != kLedClients.back()) {
    stored[index].reset();
    return Ok();
  }
  const auto effects = LegalEffects(request.target, request.mode);
  if (!effects) {
    return LedError(LedKey::kNoSuchMode, "unknown mode " + std::to_string(request.mode) +
                                             "; 1 is predefined, 2 the colour given");
  }
  if (request.effect < effects->first || request.effect > effects->last) {
    return LedError(LedKey::kNoSuchEffect, "target " + std::to_string(request.target) +
                                               " has no effect " + std::to_string(request.effect) +
                                               " in mode " + std::to_string(request.mode) +
                                               ", but " + Range(*effects));
  }
  stored[index] =
      Light{request.mode, request.effect, request.r_value, request.g_value, request.b_value};
  const std::size_t shown = FirstStored(stored);
  if (shown == index) return Ok();
  return LedError(LedKey::kStored, "stored until client '" + std::string(kLedClients[shown]) +
                                       "' releases the light");
}

LedArbiter::Shown LedArbiter::Show(std::uint8_t target) const {
  const Stored& stored = stored_.at(static_cast<std::size_t>(target - kLedTargets.front()));
  const std::size_t first = FirstStored(stored);
  return {static_cast<LedClient>(first), *stored[first]};
}

}  // namespace musher::device
