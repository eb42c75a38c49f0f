#include "musher/modules/skills/skills/nudge.hpp"

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

constexpr double kSpeedMps = 0.15;
constexpr double kTurnGainPerS = 1.5;
constexpr double kTurnRadS = 0.8;
constexpr double kStraightRad = 0.3;
constexpr double kClearanceM = 0.15;
constexpr double kOfTargetM = 0.3;

double Horizontal(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

bool ObstacleAhead(const Robot& robot, const navigation::Pose& now,
                   const navigation::Point& target) {
  return std::ranges::any_of(robot.obstacles(), [&](const navigation::Point& point) {
    if (Horizontal(point, target) <= kOfTargetM) return false;
    const double x_m = point.x_m - now.at.x_m;
    const double y_m = point.y_m - now.at.y_m;
    const double ahead_m = x_m * std::cos(now.yaw_rad) + y_m * std::sin(now.yaw_rad);
    return ahead_m > 0 && std::hypot(x_m, y_m) < robot.radius_m() + kClearanceM;
  });
}

Result<navigation::Velocity> NudgeCommand(const Robot& robot, const navigation::Point& target,
                                          const navigation::Point& start, double most_m) {
  const auto now = robot.pose();
  if (!now || !navigation::IsFinite(*now)) return Error{kCodeFailed, robot.WhyNoPose()};
  if (!robot.HasScan()) return Error{kCodeFailed, "stopped: no scan to approach by"};
  if (Horizontal(now->at, start) >= most_m) {
    return Error{kCodeFailed, "it has come as close as it may"};
  }
  const double distance_m = Horizontal(target, now->at);
  if (distance_m <= robot.radius_m()) return Error{kCodeFailed, "it is at the place already"};
  const double bearing_rad = navigation::Wrapped(
      std::atan2(target.y_m - now->at.y_m, target.x_m - now->at.x_m) - now->yaw_rad);
  navigation::Velocity command;
  command.yaw_rad_s = std::clamp(kTurnGainPerS * bearing_rad, -kTurnRadS, kTurnRadS);
  if (const std::string held = robot.HeldBy(); !held.empty()) return Error{kCodeFailed, held};
  if (std::abs(bearing_rad) > kStraightRad) return command;
  if (ObstacleAhead(robot, *now, target)) return Error{kCodeFailed, "an obstacle is in the way"};
  command.x_m_s = kSpeedMps;
  return command;
}

}  // namespace

Result<> NudgeTowards(Robot& robot, const navigation::Point& target, const navigation::Point& start,
                      double most_m) {
  const Result<navigation::Velocity> command = NudgeCommand(robot, target, start, most_m);
  if (!command) {
    robot.StopMotion();
    return command.error();
  }
  robot.SetVelocity(command.value());
  return Ok();
}

}  // namespace musher::skills
