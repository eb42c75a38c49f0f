#pragma once
// Motion within limits: as fast as they allow, and braked in time. Pure.

#include "musher/modules/world/scene/humanoid_specs.hpp"

namespace musher::world {

struct Axis {
  double position_rad = 0;
  double speed_rad_s = 0;

  friend bool operator==(const Axis&, const Axis&) = default;
};

// Where a joint is after the next step on its way to `goal_rad`. Its speed and acceleration stay
// within the limits, however the goal moves; it comes to rest at a fixed goal without overshoot,
// unless it was too fast to stop before a new goal.
Axis Approach(const Axis& from, double goal_rad, const MotionLimits& limits, double seconds);

}  // namespace musher::world
