#include "musher/modules/world/trapezoid.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {

Axis Approach(const Axis& from, double goal_rad, const MotionLimits& limits, double seconds) {
  const double way = goal_rad - from.position_rad;
  const double change = limits.acceleration_rad_s2 * seconds;  // of the speed, in a step
  // The fastest from which steps of braking end at the goal.
  const double braked =
      (std::sqrt(change * change + 8 * limits.acceleration_rad_s2 * std::abs(way)) - change) / 2;
  const double fastest = std::min({braked, std::abs(way) / seconds, limits.speed_rad_s});
  const double wanted = std::copysign(fastest, way);
  const double speed = std::clamp(wanted, from.speed_rad_s - change, from.speed_rad_s + change);
  return {from.position_rad + speed * seconds, speed};
}

}  // namespace musher::world
