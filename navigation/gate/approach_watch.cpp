#include "musher/navigation/gate/approach_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::navigation {
namespace {

constexpr Duration kLeastApart = Milliseconds(150);  // less is within the errors of the ranges
constexpr Duration kMostApart = std::chrono::seconds(1);
constexpr Duration kKeptEach = Milliseconds(40);  // of a faster scanner not every scan
constexpr double kErrorM = 0.04;         // of a range, and of the motion between two scans …
constexpr double kErrorShare = 0.02;     // … which grows with the range
constexpr double kFastestMoverMS = 2.5;  // a person who runs; a larger step is another one
constexpr std::size_t kLeastPoints = 2;

std::size_t DegreeAt(const Point& sensor, const Point& place) {
  const double angle_rad = std::atan2(place.y_m - sensor.y_m, place.x_m - sensor.x_m);
  return static_cast<std::size_t>(angle_rad * 180 / M_PI + 360) % 360;
}

double Apart(const Point& a, const Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// Of a place in the frame of `pose`, in the frame in which `pose` is given.
Point Out(const Pose& pose, const Point& place) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  return {pose.at.x_m + c * place.x_m - s * place.y_m, pose.at.y_m + s * place.x_m + c * place.y_m,
          place.z_m};
}

Point Into(const Pose& pose, const Point& place) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const double x = place.x_m - pose.at.x_m, y = place.y_m - pose.at.y_m;
  return {c * x + s * y, c * y - s * x, place.z_m};
}

const Point* Nearest(const std::vector<Point>& points, const Point& place) {
  const auto nearest = std::ranges::min_element(points, {}, [&place](const Point& point) {
    const double x = point.x_m - place.x_m, y = point.y_m - place.y_m;
    return x * x + y * y;
  });
  return nearest == points.end() ? nullptr : &*nearest;
}

}  // namespace

// How far the rays beside the direction of a place had gone; 0: there were none.
double ApproachWatch::FreeOf(const Earlier& earlier, const Point& place) {
  const std::size_t at = DegreeAt(earlier.sensor, place);
  double least_m = 0;
  for (const std::size_t degree : {(at + 359) % 360, at, (at + 1) % 360}) {
    const double free_m = earlier.free_m[degree];
    if (free_m > 0 && (least_m == 0 || free_m < least_m)) least_m = free_m;
  }
  return least_m;
}

// The latest scan that is old enough.
const ApproachWatch::Earlier* ApproachWatch::Reference(Time taken) const {
  const auto found = std::find_if(
      earlier_.rbegin(), earlier_.rend(),
      [taken](const Earlier& earlier) { return taken - earlier.taken >= kLeastApart; });
  return found == earlier_.rend() ? nullptr : &*found;
}

void ApproachWatch::Take(const ScanView& scan, const std::function<Pose(Time)>& since) {
  const Time taken = *scan.taken();
  moving_.clear();
  while (!earlier_.empty() && taken - earlier_.front().taken > kMostApart) earlier_.pop_front();
  if (const Earlier* before = Reference(taken)) {
    const Pose now_of_scan = since(taken), now_of_before = since(before->taken);
    const double seconds = ToSeconds(taken - before->taken);
    for (const Point& point : scan.points()) {
      const Point then = Out(now_of_before, Into(now_of_scan, point));
      const double range_m = Apart(then, before->sensor);
      if (range_m >= FreeOf(*before, then) - kErrorM - kErrorShare * range_m) continue;
      const Point from = Into(
          now_of_before, *Nearest(before->points, then));  // it has points: it says what is free
      const Point came = Out(now_of_scan, from);
      const double x = point.x_m - came.x_m, y = point.y_m - came.y_m;
      const double speed_m_s = std::hypot(x, y) / seconds;
      const double share = std::min(1.0, kFastestMoverMS / std::max(speed_m_s, 1e-9)) / seconds;
      moving_.push_back({point, x * share, y * share});
    }
  }
  if (moving_.size() < kLeastPoints) moving_.clear();
  if (!earlier_.empty() && taken - earlier_.back().taken < kKeptEach) return;
  Earlier& last = earlier_.emplace_back(Earlier{taken, scan.sensor(), scan.points(), {}});
  for (const Point& point : last.points) {
    double& free_m = last.free_m[DegreeAt(last.sensor, point)];
    const double range_m = Apart(point, last.sensor);
    if (free_m == 0 || range_m < free_m) free_m = range_m;
  }
}

}  // namespace musher::navigation
