#include "musher/navigation/planner/headings.hpp"

#include <algorithm>

namespace musher::navigation {
namespace {

constexpr double kTurnRad = 0.02;  // a smaller turn is done on the way
constexpr double kStillM = 1e-6;   // a step without a direction on the ground

// Of the path around point i.
double DirectionAt(const std::vector<Point>& points, std::size_t i, double otherwise_rad) {
  const Point& before = points[i == 0 ? 0 : i - 1];
  const Point& after = points[std::min(i + 1, points.size() - 1)];
  const double x_m = after.x_m - before.x_m, y_m = after.y_m - before.y_m;
  return std::hypot(x_m, y_m) < kStillM ? otherwise_rad : std::atan2(y_m, x_m);
}

Path Along(const std::vector<Point>& points, double start_yaw_rad, double goal_yaw_rad) {
  Path path = {{points[0], start_yaw_rad}};
  double yaw_rad = start_yaw_rad;
  for (std::size_t i = 0; i < points.size() && points.size() > 1; ++i) {
    yaw_rad = DirectionAt(points, i, yaw_rad);
    const bool turns = i > 0 || std::abs(Wrapped(yaw_rad - start_yaw_rad)) > kTurnRad;
    if (turns) path.push_back({points[i], yaw_rad});
  }
  if (path.size() == 1 || std::abs(Wrapped(goal_yaw_rad - yaw_rad)) > kTurnRad) {
    path.push_back({points.back(), goal_yaw_rad});
  }
  path.back().yaw_rad = goal_yaw_rad;
  return path;
}

Path Turning(const std::vector<Point>& points, double start_yaw_rad, double goal_yaw_rad) {
  double length_m = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length_m += Distance(points[i - 1], points[i]);
  const double turn_rad = Wrapped(goal_yaw_rad - start_yaw_rad);
  if (length_m < kStillM) return {{points[0], start_yaw_rad}, {points.back(), goal_yaw_rad}};
  Path path;
  double so_far_m = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) so_far_m += Distance(points[i - 1], points[i]);
    path.push_back({points[i], Wrapped(start_yaw_rad + turn_rad * so_far_m / length_m)});
  }
  path.back().yaw_rad = goal_yaw_rad;
  return path;
}

}  // namespace

Path WithHeadings(const std::vector<Point>& points, double start_yaw_rad, double goal_yaw_rad,
                  Heading heading) {
  return heading == Heading::kAlong ? Along(points, start_yaw_rad, goal_yaw_rad)
                                    : Turning(points, start_yaw_rad, goal_yaw_rad);
}

}  // namespace musher::navigation
