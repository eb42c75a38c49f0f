#pragma once
// The velocity that leads a body back to the middle of its lane and along it. Pure, without memory.
// Metres, radians, seconds; to the left positive, so a turn to the left has a positive yaw. Any
// thread.
//
//   yaw = forward * curvature - by_heading * heading - by_offset * offset
//
// With forward 0.3 m/s the defaults have a natural frequency of 0.95 rad/s and a damping of 0.9,
// which a body with a lag of 0.2 s and pictures that are 0.15 s old bear.

#include "musher/modules/line_walker/lane.hpp"

namespace musher::line_walker {

struct SteeringRules {
  double forward_m_s = 0.3;
  double slow_m_s = 0.1;                // the least, beside a curve or a heading error
  double yaw_rad_s = 0.6;               // at most, either way
  double side_m_s = 0.08;               // at most, either way
  double by_offset = 3.0;               // rad/s for a metre
  double by_heading = 1.7;              // rad/s for a radian
  double side_by_offset = 0.4;          // m/s for a metre
  double slow_from_rad = kDegree * 15;  // from this heading error on it walks more slowly
  double slow_to_rad = kDegree * 45;    // and from this on with slow_m_s

  friend bool operator==(const SteeringRules&, const SteeringRules&) = default;
};

// `at_most_m_s`: a lower limit of the forward velocity than that of the rules.
Velocity Steer(const InLane& in_lane, double at_most_m_s, const SteeringRules& rules);

}  // namespace musher::line_walker
