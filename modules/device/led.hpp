#pragma once
// Which of several clients controls a light, as a plain value without IO: each target (head, tail,
// mini) keeps the last request of every client and shows that of the first in precedence. Client
// `system` is the base: it always has a request, at first the default light.
//
// Errors carry CyberDog's codes: 1121 no such target, 1122 client, 1123 mode, 1124 effect; 1125
// the request is stored and will be shown when the clients before it release the light.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/protocol/device.hpp"

namespace musher::device {

enum class LedKey : std::int32_t {
  kNoSuchTarget = 21,
  kNoSuchClient = 22,
  kNoSuchMode = 23,
  kNoSuchEffect = 24,
  kStored = 25,
};

constexpr std::int32_t LedCode(LedKey key) {
  return static_cast<std::int32_t>(cyberdog::module_code::kLed) + static_cast<std::int32_t>(key);
}

// In the order of precedence.
enum class LedClient : std::uint8_t { kLowPower, kBms, kConnector, kVp, kTracking, kSystem };
inline constexpr std::array<std::string_view, 6> kLedClients = {"lowpower", "bms",      "connector",
                                                                "vp",       "tracking", "system"};

inline constexpr std::array<std::uint8_t, 3> kLedTargets = {
    msg::LedExecute::kHead, msg::LedExecute::kTail, msg::LedExecute::kMini};

struct Light {
  std::uint8_t mode = msg::LedExecute::kUserColor;
  std::uint8_t effect = 0;
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;

  friend bool operator==(const Light&, const Light&) = default;
};

// What `system` shows on a target before its first request.
Light DefaultLight(std::uint8_t target);

class LedArbiter {
 public:
  struct Shown {
    LedClient client = LedClient::kSystem;
    Light light;

    friend bool operator==(const Shown&, const Shown&) = default;
  };

  LedArbiter();

  // Checks target, client, mode and effect, in this order, and then takes or stores the request. A
  // release needs no mode and no effect, and may be repeated; a release of `system` counts as a
  // request.
  Result<> Execute(const msg::LedExecute::Request& request);

  // `target` is one of kLedTargets.
  Shown Show(std::uint8_t target) const;

  friend bool operator==(const LedArbiter&, const LedArbiter&) = default;

 private:
  using Stored = std::array<std::optional<Light>, kLedClients.size()>;  // by client

  std::array<Stored, kLedTargets.size()> stored_;
};

}  // namespace musher::device
