#include "musher/modules/navigation/controller_server/drive_path.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace musher::navigation {
namespace {

constexpr double kSamePlaceM = 1e-3;
constexpr double kSharpRad = 0.35;  // a larger turn is done on the spot
constexpr double kTurnWithinM = 0.2;
constexpr double kSmallTurnRad = 0.02;
constexpr double kSearchedM = 5;  // of the path, for the point nearest to the body

double Away(const Point& a, const Point& b, bool flat) {
  return flat ? std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) : Distance(a, b);
}

// The point of a line that is nearest to `place`, as a share of it.
double NearestShare(const Point& from, const Point& to, const Point& place) {
  const double x = to.x_m - from.x_m, y = to.y_m - from.y_m, z = to.z_m - from.z_m;
  const double square = x * x + y * y + z * z;
  if (square < kSamePlaceM * kSamePlaceM) return 0;
  const double along =
      (place.x_m - from.x_m) * x + (place.y_m - from.y_m) * y + (place.z_m - from.z_m) * z;
  return std::clamp(along / square, 0.0, 1.0);
}

double DirectionOf(const Point& from, const Point& to) {
  return std::atan2(to.y_m - from.y_m, to.x_m - from.x_m);
}

}  // namespace

Path JoinedPath(const Path& path, const Pose& from, double join_m, bool flat) {
  std::size_t next = 0;  // the first pose after the nearest point
  Point nearest = path[0].at;
  double least_m = Away(nearest, from.at, flat), so_far_m = 0;
  for (std::size_t i = 1; i < path.size() && so_far_m < kSearchedM; ++i) {
    const Point &a = path[i - 1].at, &b = path[i].at;
    const Point at = Between(a, b, NearestShare(a, b, from.at));
    const double away_m = Away(at, from.at, flat);
    if (away_m < least_m - kSamePlaceM) {
      least_m = away_m;
      nearest = at;
      next = i;
    }
    so_far_m += Distance(a, b);
  }
  if (least_m > join_m) return {};
  Path joined = {from};
  if (flat) joined[0].at.z_m = path[0].at.z_m;
  if (next > 0 && least_m > kSamePlaceM) joined.push_back({nearest, path[next - 1].yaw_rad});
  joined.insert(joined.end(), path.begin() + static_cast<std::ptrdiff_t>(next), path.end());
  return joined;
}

Path LookingAhead(const Path& path, bool moves) {
  std::vector<Point> points;
  for (const Pose& pose : path) {
    if (points.empty() || Away(points.back(), pose.at, true) > kSamePlaceM) {
      points.push_back(pose.at);
    }
  }
  const double start_rad = path.front().yaw_rad, goal_rad = path.back().yaw_rad;
  Path ahead = {{points[0], start_rad}};
  double yaw_rad = start_rad;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double direction_rad = DirectionOf(points[i], points[i + 1]);
    const double turn_rad = std::abs(Wrapped(direction_rad - yaw_rad));
    const double length_m = Away(points[i], points[i + 1], true);
    const double bend_m = std::min(kTurnWithinM, length_m / 2);
    const bool sharp = turn_rad > kSharpRad || (i == 0 && !moves && turn_rad > kSmallTurnRad);
    // The turn ends at the corner, or shortly behind it.
    ahead.push_back(
        {sharp ? points[i] : Between(points[i], points[i + 1], bend_m / length_m), direction_rad});
    yaw_rad = direction_rad;
    const bool last = i + 2 == points.size();
    const double next_rad = last ? goal_rad : DirectionOf(points[i + 1], points[i + 2]);
    const bool sharp_next = last || std::abs(Wrapped(next_rad - direction_rad)) > kSharpRad;
    ahead.push_back(
        {sharp_next ? points[i + 1] : Between(points[i + 1], points[i], bend_m / length_m),
         direction_rad});
  }
  if (std::abs(Wrapped(goal_rad - yaw_rad)) > kSmallTurnRad) {
    ahead.push_back({points.back(), goal_rad});
  }
  ahead.back().yaw_rad = goal_rad;
  return ahead;
}

}  // namespace musher::navigation
