#include "musher/behavior/tree/nav2/geometry.hpp"

#include <cmath>

namespace musher::tree::nav2 {

double Distance(const Pose& a, const Pose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m, a.z_m - b.z_m);
}

double LengthOf(const Path& path) {
  double length_m = 0;
  for (std::size_t i = 1; i < path.poses.size(); ++i) {
    length_m += Distance(path.poses[i - 1], path.poses[i]);
  }
  return length_m;
}

}  // namespace musher::tree::nav2

namespace musher::tree {

Result<nav2::Pose> Convert<nav2::Pose>::FromText(std::string_view text) {
  const auto numbers = Convert<std::vector<double>>::FromText(text);
  if (!numbers || numbers.value().size() != 3) return NoValue(text, kName);
  const std::vector<double>& values = numbers.value();
  return nav2::Pose{.x_m = values[0], .y_m = values[1], .yaw_rad = values[2]};
}

}  // namespace musher::tree
