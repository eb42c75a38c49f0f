#include "musher/modules/device/lights.hpp"

#include <string>

#include "musher/modules/device/led.hpp"

namespace musher::device {
namespace {

using msg::LedExecute;

constexpr int kLowPercent = 20;
constexpr int kHighPercent = 80;

constexpr Light UserColor(std::uint8_t effect, std::uint32_t rgb) {
  return {LedExecute::kUserColor, effect, static_cast<std::uint8_t>(rgb >> 16U),
          static_cast<std::uint8_t>(rgb >> 8U), static_cast<std::uint8_t>(rgb)};
}

LedExecute::Request Show(LedClient client, std::uint8_t target, const Light& light) {
  return {true,         std::string(kLedClients[static_cast<std::size_t>(client)]),
          target,       light.mode,
          light.effect, light.r,
          light.g,      light.b};
}

LedExecute::Request Release(LedClient client, std::uint8_t target) {
  LedExecute::Request request;
  request.client = kLedClients[static_cast<std::size_t>(client)];
  request.target = target;
  return request;
}

}  // namespace

LightRequests BatteryLights(int percent, bool charging) {
  const bool low = percent <= kLowPercent;
  const std::uint32_t rgb = low ? 0xFF3232 : percent < kHighPercent ? 0x75FCF6 : 0x0621E2;
  const Light light = UserColor(charging ? LedExecute::kOneByOne : LedExecute::kTrailingRace, rgb);
  LightRequests requests;
  for (const std::uint8_t target : {LedExecute::kHead, LedExecute::kTail}) {
    if (low || charging) {
      requests.push_back(Show(LedClient::kBms, target, light));
    } else {
      requests.push_back(Show(LedClient::kSystem, target, light));
      requests.push_back(Release(LedClient::kBms, target));
    }
  }
  requests.push_back(low && !charging ? Show(LedClient::kBms, LedExecute::kMini,
                                             UserColor(LedExecute::kCircularBreath, 0xFF0000))
                                      : Release(LedClient::kBms, LedExecute::kMini));
  return requests;
}

LightRequests LowPowerLights(bool low_power) {
  LightRequests requests;
  for (const std::uint8_t target : kLedTargets) {
    requests.push_back(low_power && target == LedExecute::kTail
                           ? Show(LedClient::kLowPower, target,
                                  {LedExecute::kPredefined, LedExecute::kRgbOff, 0, 0, 0})
                           : Release(LedClient::kLowPower, target));
  }
  return requests;
}

LightRequests LeavingLowPowerLights() {
  LightRequests requests = LowPowerLights(false);
  requests.push_back(
      Show(LedClient::kSystem, LedExecute::kTail, UserColor(LedExecute::kBreath, 0x0621E2)));
  return requests;
}

LightRequests ShutdownLights() {
  const Light blinking = {LedExecute::kPredefined, LedExecute::kRedBlinkFast, 0, 0, 0};
  return {Show(LedClient::kLowPower, LedExecute::kHead, blinking),
          Show(LedClient::kLowPower, LedExecute::kTail, blinking),
          Show(LedClient::kLowPower, LedExecute::kMini,
               UserColor(LedExecute::kCircularRing, 0xFF0000))};
}

}  // namespace musher::device
