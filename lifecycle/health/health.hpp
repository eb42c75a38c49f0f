#pragma once
// The health of an actuator, and the rule that evaluates its silence.

#include <string_view>

#include "musher/base/time.hpp"
#include "musher/lifecycle/field.hpp"

namespace musher {

enum class Health {
  kWell,
  kStarved,      // alive, but waiting for a CPU or the disk: reported, not restarted
  kHung,         // could run and made no progress
  kCrashed,      // its process has exited; on another host, as far as its silence says
  kPartitioned,  // the connection to its whole host is lost
};
std::string_view HealthName(Health health);  // "well", "starved", …

// So much of a wait for the disk does not count as silence: on a disk that has failed, a process
// waits for ever.
inline constexpr Duration kLongestDiskWait = std::chrono::seconds(10);

// Evaluates a process that has been silent for `silent`, where `allowance` is the limit. For
// `waited` of that time it could not run, for want of a CPU or of the disk: that time does not
// count. Gives kWell, kStarved or kHung.
Health EvaluateSilence(Duration silent, Duration allowance, Duration waited);

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 5> kValueNames<Health> = {"well", "starved", "hung",
                                                                        "crashed", "partitioned"};
static_assert(EndsWith(Health::kPartitioned));

}  // namespace musher::fields
