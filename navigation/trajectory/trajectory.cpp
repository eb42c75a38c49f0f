#include "musher/navigation/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr double kStepS = ToSeconds(kTrajectoryStep);

Result<> CheckRules(const TrajectoryRules& rules) {
  const MotionLimits& limits = rules.limits;
  const auto bad = [](double limit) { return !std::isfinite(limit) || limit <= 0; };
  if (bad(limits.speed_m_s) || bad(limits.acceleration_m_s2) || bad(limits.yaw_rad_s) ||
      bad(limits.yaw_rad_s2) || bad(rules.corner_m)) {
    return MakeError(Fault::kInput,
                     fmt::format("trajectory: limits {} m/s, {} m/s², {} rad/s, {} rad/s², corner "
                                 "{} m; expected positive numbers",
                                 limits.speed_m_s, limits.acceleration_m_s2, limits.yaw_rad_s,
                                 limits.yaw_rad_s2, rules.corner_m));
  }
  if (!std::isfinite(rules.start_speed_m_s) || rules.start_speed_m_s < 0) {
    return MakeError(
        Fault::kInput,
        fmt::format("trajectory: start speed {} m/s, expected 0 or more", rules.start_speed_m_s));
  }
  return Ok();
}

Velocity VelocityOf(const Axes& axes) {
  return {axes[0], axes[1], axes[2], axes[3]};
}

TrajectoryPoint PointIn(const CurvePiece& piece, const Interval& interval, double seconds) {
  const double w = std::max(0.0, std::sqrt(interval.x) + interval.acceleration * seconds);
  const double s = interval.from + std::clamp(std::sqrt(interval.x) * seconds +
                                                  interval.acceleration * seconds * seconds / 2,
                                              0.0, interval.length);
  const Axes place = piece.PlaceAt(s), slope = piece.SlopeAt(s);
  Axes velocity{}, acceleration{};
  for (std::size_t i = 0; i < slope.size(); ++i) {
    velocity[i] = slope[i] * w;
    acceleration[i] = slope[i] * interval.acceleration + piece.bend[i] * w * w;
  }
  return {
      {{place[0], place[1], place[2]}, place[3]}, VelocityOf(velocity), VelocityOf(acceleration)};
}

double Mixed(double a, double b, double share) {
  return a + share * (b - a);
}

Velocity Mixed(const Velocity& a, const Velocity& b, double share) {
  return {Mixed(a.x_m_s, b.x_m_s, share), Mixed(a.y_m_s, b.y_m_s, share),
          Mixed(a.z_m_s, b.z_m_s, share), Mixed(a.yaw_rad_s, b.yaw_rad_s, share)};
}

// A cubic by the places and the velocities at both ends of a step.
double Cubic(double a, double velocity_a, double b, double velocity_b, double share) {
  const double square = share * share, cube = square * share;
  return a * (2 * cube - 3 * square + 1) + velocity_a * kStepS * (cube - 2 * square + share) +
         b * (3 * square - 2 * cube) + velocity_b * kStepS * (cube - square);
}

}  // namespace

TrajectoryPoint Trajectory::At(Duration since_begin) const {
  if (since_begin <= Duration::zero()) return points.front();
  if (since_begin >= duration()) return points.back();
  const auto index = static_cast<std::size_t>(since_begin / kTrajectoryStep);
  const double share = ToSeconds(since_begin % kTrajectoryStep) / kStepS;
  const TrajectoryPoint &a = points[index], &b = points[index + 1];
  const Velocity &from = a.velocity, &to = b.velocity;
  TrajectoryPoint point;
  point.pose.at.x_m = Cubic(a.pose.at.x_m, from.x_m_s, b.pose.at.x_m, to.x_m_s, share);
  point.pose.at.y_m = Cubic(a.pose.at.y_m, from.y_m_s, b.pose.at.y_m, to.y_m_s, share);
  point.pose.at.z_m = Cubic(a.pose.at.z_m, from.z_m_s, b.pose.at.z_m, to.z_m_s, share);
  point.pose.yaw_rad = Cubic(a.pose.yaw_rad, from.yaw_rad_s, b.pose.yaw_rad, to.yaw_rad_s, share);
  point.velocity = Mixed(from, to, share);
  point.acceleration = Mixed(a.acceleration, b.acceleration, share);
  return point;
}

Result<Trajectory> MakeTrajectory(const Path& path, const TrajectoryRules& rules) {
  auto checked = CheckRules(rules);
  if (!checked.ok()) return checked.error();
  auto curve = MakeCurve(path, rules.corner_m);
  if (!curve.ok()) return curve.error();
  const std::vector<CurvePiece>& pieces = curve.value();
  Trajectory trajectory;
  if (pieces.empty()) {
    trajectory.points.push_back({path.back(), {}, {}});
    return trajectory;
  }
  double begin_s = 0;
  for (const Interval& interval : FastestProgress(pieces, rules.limits, rules.start_speed_m_s)) {
    const double end_s = begin_s + interval.seconds;
    for (;;) {
      const double at_s = static_cast<double>(trajectory.points.size()) * kStepS;
      if (at_s >= end_s) break;
      trajectory.points.push_back(PointIn(pieces[interval.piece], interval, at_s - begin_s));
    }
    begin_s = end_s;
  }
  const Axes end = pieces.back().PlaceAt(pieces.back().length);
  trajectory.points.push_back({{{end[0], end[1], end[2]}, end[3]}, {}, {}});
  return trajectory;
}

}  // namespace musher::navigation
