#include "musher/modules/world/body/trapezoid.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {

namespace {

// The fastest speed, in speed changes a step, from which braking ends after `way`, measured in the
// distance of one change a step: whole steps of braking from (k + f) go (k + f) + (k - 1 + f) +
// ... + f.
double Braking(double way) {
  const double steps = std::floor((std::sqrt(1 + 8 * way) - 1) / 2);
  return steps + (way - steps * (steps + 1) / 2) / (steps + 1);
}

}  // namespace

Axis Approach(const Axis& from, double goal_rad, const MotionLimits& limits, double seconds) {
  const double way = goal_rad - from.position_rad;
  const double change = limits.acceleration_rad_s2 * seconds;  // of the speed, in a step
  const double fastest =
      std::min(change * Braking(std::abs(way) / (change * seconds)), limits.speed_rad_s);
  const double speed =
      std::clamp(std::copysign(fastest, way), from.speed_rad_s - change, from.speed_rad_s + change);
  return {from.position_rad + speed * seconds, speed};
}

}  // namespace musher::world
