#include "musher/behavior/tree/nav2/path_places.hpp"

#include <algorithm>
#include <cmath>

namespace musher::tree::nav2 {
namespace {

// Its direction is that of `a`, up to `b`.
Pose Between(const Pose& a, const Pose& b, double share) {
  if (share >= 1) return b;
  Pose between = a;
  between.x_m += share * (b.x_m - a.x_m);
  between.y_m += share * (b.y_m - a.y_m);
  between.z_m += share * (b.z_m - a.z_m);
  return between;
}

Pose PlaceAt(const Path& path, double along_m) {
  double begin_m = 0;
  for (std::size_t i = 1; i < path.poses.size(); ++i) {
    const double length_m = Distance(path.poses[i - 1], path.poses[i]);
    if (along_m < begin_m + length_m) {
      const double share = std::max(0.0, (along_m - begin_m) / length_m);
      return Between(path.poses[i - 1], path.poses[i], share);
    }
    begin_m += length_m;
  }
  return path.poses.back();
}

// Returns which share of the line from `a` to `b` ends at its place nearest to `to`: 0 at `a`, 1 at
// `b`.
double ShareNearest(const Robot& robot, const Pose& a, const Pose& b, const Pose& to) {
  const double x = b.x_m - a.x_m, y = b.y_m - a.y_m, z = robot.flies() ? b.z_m - a.z_m : 0;
  const double square = x * x + y * y + z * z;
  if (square == 0) return 0;
  const double along = (to.x_m - a.x_m) * x + (to.y_m - a.y_m) * y + (to.z_m - a.z_m) * z;
  return std::clamp(along / square, 0.0, 1.0);
}

double TurnBetween(double a_rad, double b_rad) {
  return std::remainder(a_rad - b_rad, 2 * M_PI);
}

// Between `outside` and `inside`, at that distance from `end`.
Pose Crossing(const Pose& outside, const Pose& inside, const Pose& end, double distance_m) {
  const double x = inside.x_m - outside.x_m, y = inside.y_m - outside.y_m;
  const double z = inside.z_m - outside.z_m;
  const double to_x = end.x_m - outside.x_m, to_y = end.y_m - outside.y_m;
  const double to_z = end.z_m - outside.z_m;
  const double square = x * x + y * y + z * z;
  const double dot = x * to_x + y * to_y + z * to_z;
  const double off = to_x * to_x + to_y * to_y + to_z * to_z - distance_m * distance_m;
  const double root = std::sqrt(std::max(0.0, dot * dot - square * off));
  return Between(outside, inside, std::clamp((dot - root) / square, 0.0, 1.0));
}

}  // namespace

Path Part(const Path& path, double from_m, double until_m) {
  until_m = std::min(until_m, LengthOf(path));
  Path part{{PlaceAt(path, from_m)}};
  double along_m = 0;
  for (std::size_t i = 1; i < path.poses.size(); ++i) {
    along_m += Distance(path.poses[i - 1], path.poses[i]);
    if (along_m > from_m && along_m < until_m) part.poses.push_back(path.poses[i]);
  }
  if (until_m > from_m) part.poses.push_back(PlaceAt(path, until_m));
  return part;
}

Path EndingBefore(Path path, double distance_m) {
  if (path.poses.empty()) return path;
  const Pose end = path.poses.back();
  Pose inside = end;
  while (path.poses.size() > 1 && Distance(path.poses.back(), end) < distance_m) {
    inside = path.poses.back();
    path.poses.pop_back();
  }
  const Pose outside = path.poses.back();
  if (Distance(outside, end) >= distance_m && Distance(outside, inside) > 0) {
    const Pose crossing = Crossing(outside, inside, end, distance_m);
    if (Distance(crossing, outside) > 0) path.poses.push_back(crossing);
  }
  Pose& last = path.poses.back();
  if (last.x_m != end.x_m || last.y_m != end.y_m) {
    last.yaw_rad = std::atan2(end.y_m - last.y_m, end.x_m - last.x_m);
  }
  return path;
}

Tracking TrackingAt(const Path& path, const Pose& pose, double along_m) {
  const Pose place = PlaceAt(path, along_m);
  double direction_rad = place.yaw_rad, begin_m = 0;  // of the last line up to there
  for (std::size_t i = 1; i < path.poses.size() && begin_m <= along_m; ++i) {
    const Pose &a = path.poses[i - 1], &b = path.poses[i];
    const double length_m = Distance(a, b);
    if (length_m > 0) direction_rad = std::atan2(b.y_m - a.y_m, b.x_m - a.x_m);
    begin_m += length_m;
  }
  const double x = pose.x_m - place.x_m, y = pose.y_m - place.y_m;
  const double to_left = std::cos(direction_rad) * y - std::sin(direction_rad) * x;
  return {.off_m = std::copysign(std::hypot(x, y), to_left),
          .heading_rad = TurnBetween(pose.yaw_rad, direction_rad),
          .left_m = LengthOf(path) - along_m};
}

double PathProgress::Along(const Robot& robot, const Path& path, const Pose& pose, double search_m,
                           double m_per_rad) {
  if (path != path_) {
    path_ = path;
    found_m_ = 0;
  }
  const double from_m = search_m < kNoLimit ? found_m_ : 0;
  const double until_m = from_m + search_m;
  double least_m = kNoLimit, begin_m = 0;
  found_m_ = from_m;
  for (std::size_t i = 1; i < path.poses.size() && begin_m <= until_m; ++i) {
    const Pose &a = path.poses[i - 1], &b = path.poses[i];
    const double length_m = Distance(a, b), end_m = begin_m + length_m;
    if (end_m >= from_m) {
      const double nearest_m = begin_m + ShareNearest(robot, a, b, pose) * length_m;
      const double along_m =
          std::clamp(nearest_m, std::max(begin_m, from_m), std::min(end_m, until_m));
      const Pose place = Between(a, b, length_m > 0 ? (along_m - begin_m) / length_m : 0);
      const double off_m = std::hypot(Apart(robot, place, pose),
                                      m_per_rad * TurnBetween(place.yaw_rad, pose.yaw_rad));
      if (off_m < least_m) {
        least_m = off_m;
        found_m_ = along_m;
      }
    }
    begin_m = end_m;
  }
  return found_m_;
}

}  // namespace musher::tree::nav2
