#pragma once
// Between ROS 2's orientations and the yaw (rad, to the left of x) of bodies that stand upright.
// Any thread.

#include <cmath>

#include "musher/messages/geometry_msgs/geometry.hpp"

namespace musher::msg {

// Where the x axis points, seen from above. The length of the quaternion does not matter, but 0.
inline double YawOf(const Quaternion& q) {
  return std::atan2(2 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
}
inline Quaternion FromYaw(double yaw_rad) {
  return {0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
}

}  // namespace musher::msg
