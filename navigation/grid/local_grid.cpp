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

void LocalGrid::NotePlace(const Point& place) {
  constexpr double kJumpM = 0.5;
  if (place_ && Distance(*place_, place) > kJumpM) Clear();
  place_ = place;
}

bool LocalGrid::IsPassed(const Mark& mark, const Scan& scan, const Pose& sensor) const {
  const double x = mark.at.x_m - sensor.at.x_m, y = mark.at.y_m - sensor.at.y_m;
  const double away_m = std::hypot(x, y);
  // In rays from the first one on.
  double rays = Wrapped(std::atan2(y, x) - sensor.yaw_rad - scan.from_rad) / scan.step_rad;
  if (rays < -0.5) rays += 2 * M_PI / std::abs(scan.step_rad);
  const double index = std::round(rays);
  if (!(index >= 0 && index < static_cast<double>(scan.ranges_m.size()))) return false;
  const double aside_m = away_m * std::abs((rays - index) * scan.step_rad);
  const double range_m = scan.ranges_m[static_cast<std::size_t>(index)];
  if (!(range_m >= scan.least_m)) return false;  // it says nothing
  const double clears_m = std::min(range_m, scan.most_m) - 2 * rules_.resolution_m;
  return aside_m <= rules_.resolution_m && away_m < clears_m;
}

void LocalGrid::Add(const Scan& scan, const Pose& sensor, Time now) {
  const bool known = IsFinite(sensor) && std::abs(sensor.at.x_m) < kFarthestM &&
                     std::abs(sensor.at.y_m) < kFarthestM;
  if (!known || !std::isfinite(scan.from_rad) || !std::isnormal(scan.step_rad)) return;
  middle_ = sensor.at;
  for (Mark& mark : marks_) {
    if (mark.seen && IsNear(mark.at) && IsPassed(mark, scan, sensor)) mark.seen.reset();
  }
  for (const Point& point : navigation::PointsOf(scan, sensor)) {
    if (IsNear(point)) At(IndexOf(point.x_m, point.y_m)) = {point, now};
  }
}

void LocalGrid::Clear() {
  for (Mark& mark : marks_) mark.seen.reset();
  place_.reset();
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
