#include "musher/navigation/grid/local_grid.hpp"

#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

constexpr double kFarthestM = 1e6;  // cells beyond it are not counted

std::int64_t Modulo(std::int64_t value, std::int64_t by) {
  const std::int64_t rest = value % by;
  return rest < 0 ? rest + by : rest;
}

}  // namespace

LocalGrid::LocalGrid(const LocalGridRules& rules)
    : rules_(rules),
      cells_(std::max<std::int64_t>(1, std::llround(rules.side_m / rules.resolution_m))),
      marks_(static_cast<std::size_t>(cells_ * cells_)) {}

LocalGrid::Index LocalGrid::IndexOf(double x_m, double y_m) const {
  return {static_cast<std::int64_t>(std::floor(x_m / rules_.resolution_m)),
          static_cast<std::int64_t>(std::floor(y_m / rules_.resolution_m))};
}

LocalGrid::Mark& LocalGrid::At(const Index& index) {
  return marks_[static_cast<std::size_t>(Modulo(index.y, cells_) * cells_ +
                                         Modulo(index.x, cells_))];
}

bool LocalGrid::IsNear(const Point& point) const {
  const double half_m = rules_.side_m / 2 - rules_.resolution_m;
  return std::abs(point.x_m - middle_.x_m) < half_m && std::abs(point.y_m - middle_.y_m) < half_m;
}

// The cells that the ray passes, but those around its end.
void LocalGrid::ClearRay(const Pose& sensor, double angle_rad, double length_m) {
  const double step_m = rules_.resolution_m / 2, c = std::cos(angle_rad), s = std::sin(angle_rad);
  const double end_m = std::min(length_m - 2 * rules_.resolution_m, rules_.side_m);
  for (double along_m = 0; along_m < end_m; along_m += step_m) {
    const Point at{sensor.at.x_m + along_m * c, sensor.at.y_m + along_m * s, 0};
    if (!IsNear(at)) return;
    At(IndexOf(at.x_m, at.y_m)).seen.reset();
  }
}

void LocalGrid::Add(const Scan& scan, const Pose& sensor, Time now) {
  const bool known = IsFinite(sensor) && std::abs(sensor.at.x_m) < kFarthestM &&
                     std::abs(sensor.at.y_m) < kFarthestM;
  if (!known || !std::isfinite(scan.from_rad) || !std::isfinite(scan.step_rad)) return;
  middle_ = sensor.at;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = scan.ranges_m[i];
    if (!(range_m >= scan.least_m)) continue;  // it says nothing
    const double angle = sensor.yaw_rad + scan.from_rad + static_cast<double>(i) * scan.step_rad;
    ClearRay(sensor, angle, std::min(range_m, scan.most_m));
  }
  for (const Point& point : navigation::PointsOf(scan, sensor)) {
    if (IsNear(point)) At(IndexOf(point.x_m, point.y_m)) = {point, now};
  }
}

void LocalGrid::Clear() {
  for (Mark& mark : marks_) mark.seen.reset();
}

std::vector<Point> LocalGrid::Points(Time now) const {
  std::vector<Point> points;
  for (const Mark& mark : marks_) {
    const bool recent = mark.seen && now - *mark.seen <= rules_.decay;
    if (recent && IsNear(mark.at)) points.push_back(mark.at);
  }
  return points;
}

}  // namespace musher::navigation
