#pragma once
// Where a flyer tries to land whose place is taken: on rings around it, the nearest places first,
// and after each ring at its place again, which may be free by then.
// Metres. Pure.

#include <cmath>
#include <optional>

#include "musher/navigation/pose.hpp"

namespace musher::skills {

inline constexpr double kLandingRingM = 0.7;  // between rings: a person and a body beside it
inline constexpr int kLandingsARing = 8;

// How many of the first ones are elsewhere.
inline int PlacesAside(int tried) {
  return tried - tried / (kLandingsARing + 1);
}

// The place number `tried` at the height of `around`; nullopt: there is none within `most_m`.
inline std::optional<navigation::Point> LandingPlace(const navigation::Point& around, int tried,
                                                     double most_m) {
  const int ring = tried / (kLandingsARing + 1), at = tried % (kLandingsARing + 1);
  const double ring_m = kLandingRingM * (1 + ring);
  if (!(ring_m <= most_m)) return std::nullopt;
  if (at == kLandingsARing) return around;
  const double angle_rad = 2 * M_PI * at / kLandingsARing;
  return navigation::Point{around.x_m + ring_m * std::cos(angle_rad),
                           around.y_m + ring_m * std::sin(angle_rad), around.z_m};
}

}  // namespace musher::skills
