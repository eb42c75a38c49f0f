#pragma once
// What is wrong with an actuator, in one word, and the rule by which silence is judged.

#include <string_view>

#include "musher/lifecycle/time.hpp"

namespace musher {

enum class Health {
  kWell,
  kStarved,      // alive, but kept waiting for a CPU: told, and left alone
  kHung,         // had its chances to run and did not get anywhere
  kCrashed,      // its process has ended
  kPartitioned,  // its whole host is out of reach
};
std::string_view HealthName(Health health);  // "well", "starved", …

// Judges somebody who has been silent for `silent` and should not be for longer than `allowance`.
// For `waited` of that time it was ready to run and got no CPU: that is not its fault and does not
// count. Gives kWell, kStarved or kHung.
Health EvaluateSilence(Duration silent, Duration allowance, Duration waited);

}  // namespace musher
