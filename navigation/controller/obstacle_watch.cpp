#include "musher/navigation/controller/obstacle_watch.hpp"

#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

constexpr double kLookEveryM = 0.03;  // of the path
constexpr double kNearerM = 0.01;     // what counts as coming nearer
constexpr int kMostSteps = 15'000;    // five minutes of a trajectory

double Apart(const Point& a, const Point& b, bool flat) {
  return flat ? std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) : Distance(a, b);
}

}  // namespace

std::vector<Point> PointsOf(const Scan& scan, const Pose& sensor) {
  std::vector<Point> points;
  if (!IsFinite(sensor)) return points;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double range_m = scan.ranges_m[i];
    if (!(range_m >= scan.least_m && range_m <= scan.most_m)) continue;
    const double angle = sensor.yaw_rad + scan.from_rad + static_cast<double>(i) * scan.step_rad;
    points.push_back({sensor.at.x_m + range_m * std::cos(angle),
                      sensor.at.y_m + range_m * std::sin(angle), sensor.at.z_m});
  }
  return points;
}

double BrakingDistance(double speed_m_s, const ObstacleRules& rules) {
  return speed_m_s * rules.reaction_s + speed_m_s * speed_m_s / (2 * rules.brake_m_s2);
}

std::optional<Obstruction> FirstObstruction(const Trajectory& trajectory, Duration since_begin,
                                            double ahead_m, const std::vector<Point>& obstacles,
                                            bool flat, const ObstacleRules& rules) {
  const double keep_m = rules.radius_m + rules.margin_m;
  const Point here = trajectory.At(since_begin).pose.at;
  std::vector<std::pair<Point, double>> near;  // with their distance now
  for (const Point& obstacle : obstacles) {
    if (!IsFinite(obstacle)) continue;
    const double away_m = Apart(obstacle, here, flat);
    if (away_m <= ahead_m + keep_m) near.emplace_back(obstacle, away_m);
  }
  if (near.empty()) return std::nullopt;
  double ahead = 0, looked_m = 0;
  Point last = here;
  for (int i = 1; i < kMostSteps && ahead < ahead_m; ++i) {
    const Duration at = since_begin + i * kTrajectoryStep;
    const Point place = trajectory.At(at).pose.at;
    ahead += Apart(place, last, flat);
    last = place;
    const bool ends = at >= trajectory.duration();
    if (ahead - looked_m < kLookEveryM && !ends) continue;
    looked_m = ahead;
    for (const auto& [obstacle, now_m] : near) {
      const double away_m = Apart(obstacle, place, flat);
      if (away_m < keep_m && away_m < now_m - kNearerM) return Obstruction{obstacle, ahead};
    }
    if (ends) break;
  }
  return std::nullopt;
}

}  // namespace musher::navigation
