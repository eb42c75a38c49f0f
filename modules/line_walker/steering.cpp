#include "musher/modules/line_walker/steering.hpp"

#include <algorithm>
#include <cmath>

namespace musher::line_walker {
namespace {

constexpr double kYawForCurves = 0.7;  // share of the yaw limit; the rest is for corrections

}  // namespace

Velocity Steer(const InLane& in_lane, double at_most_m_s, const SteeringRules& rules) {
  // Of the body's own arc, beside the lane's middle.
  const double curvature =
      in_lane.curvature_per_m / std::max(0.4, 1 - in_lane.curvature_per_m * in_lane.offset_m);
  double forward = rules.forward_m_s;
  if (curvature != 0) {
    forward = std::min(forward, kYawForCurves * rules.yaw_rad_s / std::abs(curvature));
  }
  const double excess = (std::abs(in_lane.heading_rad) - rules.slow_from_rad) /
                        (rules.slow_to_rad - rules.slow_from_rad);
  forward *= 1 - std::clamp(excess, 0.0, 1.0);
  forward = std::min(std::max(forward, rules.slow_m_s), at_most_m_s);
  Velocity velocity;
  velocity.forward_m_s = forward;
  velocity.yaw_rad_s = std::clamp(forward * curvature - rules.by_heading * in_lane.heading_rad -
                                      rules.by_offset * in_lane.offset_m,
                                  -rules.yaw_rad_s, rules.yaw_rad_s);
  velocity.left_m_s =
      std::clamp(-rules.side_by_offset * in_lane.offset_m, -rules.side_m_s, rules.side_m_s);
  return velocity;
}

}  // namespace musher::line_walker
