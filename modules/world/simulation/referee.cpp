#include "musher/modules/world/simulation/referee.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr std::size_t kMostKept = 1000;  // visits, touches
constexpr double kMovedM = 0.02;
constexpr double kRoundingM = 1e-9;

double DistanceTo(const Line& line, const Vector2d& point_m) {
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i) {
    const Vector2d& from = line.points_m[i];
    const Vector2d along = line.points_m[i + 1] - from;
    const double length2 = along.squaredNorm();
    const double share =
        length2 > 0 ? std::clamp((point_m - from).dot(along) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (point_m - from - share * along).norm());
  }
  return nearest;
}

bool IsInside(const Zone& zone, const Vector2d& point_m) {
  const Vector2d local = Rotation2Dd(-zone.yaw_rad) * (point_m - zone.center_m);
  return (local.cwiseAbs() - zone.half_m).maxCoeff() <= kRoundingM;
}

}  // namespace

Vector2d FootOf(const RefereeSpec& spec, const Pose2& pose, std::size_t foot) {
  const double ahead = foot < 2 ? spec.stance_length_m / 2 : -spec.stance_length_m / 2;
  const double left = foot % 2 == 0 ? spec.stance_width_m / 2 : -spec.stance_width_m / 2;
  return pose.position_m + Rotation2Dd(pose.yaw_rad) * Vector2d(ahead, left);
}

bool IsReached(const Zone& zone, const RefereeSpec& spec, const RobotSeen& robot) {
  if (!zone.lie) return IsInside(zone, robot.pose.position_m);
  if (!robot.lies) return false;
  const Vector2d half(spec.body_length_m / 2, spec.body_width_m / 2);
  for (const Vector2d& corner :
       {Vector2d(1, 1), Vector2d(1, -1), Vector2d(-1, 1), Vector2d(-1, -1)}) {
    const Vector2d of_body = Rotation2Dd(robot.pose.yaw_rad) * half.cwiseProduct(corner);
    if (!IsInside(zone, robot.pose.position_m + of_body)) return false;
  }
  return true;
}

Referee::Referee(const Scene& scene, const RobotSeen& robot)
    : start_m_(robot.pose.position_m), inside_(scene.zones.size(), false) {
  FindZones(scene, robot, {});
  FindLines(scene, robot, {});
}

void Referee::Step(const Scene& scene, const RobotSeen& robot, Duration now) {
  if (!began_ && (robot.pose.position_m - start_m_).norm() > kMovedM) began_ = now;
  FindZones(scene, robot, now);
  FindLines(scene, robot, now);
}

void Referee::Carry(const Scene& scene, const RobotSeen& robot, Duration now) {
  ++carried_;
  start_m_ = robot.pose.position_m;
  feet_ = {};  // a contact ends
  FindZones(scene, robot, now);
  FindLines(scene, robot, now);
}

void Referee::FindZones(const Scene& scene, const RobotSeen& robot, Duration now) {
  const std::vector<std::string>& order = scene.referee.order;
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    const bool was_inside = inside_[i];
    inside_[i] = IsReached(scene.zones[i], scene.referee, robot);
    if (was_inside || !inside_[i]) continue;
    if (visits_.size() < kMostKept) visits_.push_back({i, now});
    if (reached_ >= order.size() || order[reached_] != scene.zones[i].name) continue;
    ++reached_;
    if (reached_ == order.size()) finished_ = now;
  }
}

void Referee::FindLines(const Scene& scene, const RobotSeen& robot, Duration now) {
  for (std::size_t foot = 0; foot < feet_.size(); ++foot) {
    LineTouch touch{foot, 0, now, now, 0, FootOf(scene.referee, robot.pose, foot), false};
    for (std::size_t i = 0; !robot.in_the_air && i < scene.lines.size(); ++i) {
      const Line& line = scene.lines[i];
      if (!line.watched) continue;
      const double reach = (scene.referee.foot_m + line.width_m) / 2;
      const double depth = reach - DistanceTo(line, touch.where_m);
      if (depth <= std::max(touch.depth_m, kRoundingM)) continue;
      touch.depth_m = depth;
      touch.line = i;
      touch.whole_foot = depth >= std::min(scene.referee.foot_m, line.width_m);
    }
    Keep(foot, touch);
  }
}

void Referee::Keep(std::size_t index, const LineTouch& touch) {
  Foot& foot = feet_[index];
  if (touch.depth_m <= 0) {
    foot = {};
    return;
  }
  if (!foot.on_line) {
    foot.on_line = true;
    ++touch_count_;
    if (touches_.size() < kMostKept) {
      foot.touch = touches_.size();
      touches_.push_back(touch);
    }
  }
  if (touch.whole_foot && !foot.whole_foot) {
    foot.whole_foot = true;
    ++whole_foot_count_;
  }
  if (!foot.touch) return;
  LineTouch& kept = touches_[*foot.touch];
  kept.to = touch.to;
  if (touch.depth_m > kept.depth_m) {
    kept.depth_m = touch.depth_m;
    kept.line = touch.line;
    kept.where_m = touch.where_m;
  }
  kept.whole_foot = foot.whole_foot;
}

}  // namespace musher::world
