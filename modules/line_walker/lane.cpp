#include "musher/modules/line_walker/lane.hpp"

#include <algorithm>
#include <cmath>

namespace musher::line_walker {
namespace {

constexpr double kStraightPerM = 1e-4;  // less curvature is none
constexpr double kTightestPerM = 1.25;  // of a lane's middle

}  // namespace

InLane InLaneBy(const SideLine& line, Side side, double lane_width_m) {
  const double half_m = lane_width_m / 2;
  const bool left = side == Side::kLeft;
  InLane in_lane;
  in_lane.offset_m = left ? half_m - line.distance_m : line.distance_m - half_m;
  in_lane.heading_rad = -line.heading_rad;
  // Of the parallel arc through the lane's middle.
  const double scale = 1 + (left ? half_m : -half_m) * line.curvature_per_m;
  in_lane.curvature_per_m =
      std::clamp(line.curvature_per_m / std::max(0.3, scale), -kTightestPerM, kTightestPerM);
  return in_lane;
}

bool LaneEstimate::MayBeFirst(const SideLine& line, Side side) const {
  const InLane seen = InLaneBy(line, side, rules_.width_m);
  return std::abs(seen.offset_m) <= rules_.first_aside_m &&
         std::abs(seen.heading_rad) <= rules_.first_rad;
}

InLane LaneEstimate::At(const Pose& pose) const {
  const double cosine = std::cos(middle_.yaw_rad);
  const double sine = std::sin(middle_.yaw_rad);
  const double dx = pose.x_m - middle_.x_m;
  const double dy = pose.y_m - middle_.y_m;
  const double along_m = cosine * dx + sine * dy;
  const double left_m = cosine * dy - sine * dx;
  const double turned = curvature_per_m_ * along_m;
  const double inwards = 1 - curvature_per_m_ * left_m;
  InLane in_lane;
  in_lane.curvature_per_m = curvature_per_m_;
  if (std::abs(curvature_per_m_) < kStraightPerM) {
    in_lane.offset_m = left_m;
    in_lane.heading_rad = Wrapped(pose.yaw_rad - middle_.yaw_rad);
    return in_lane;
  }
  in_lane.offset_m = (1 - std::hypot(turned, inwards)) / curvature_per_m_;
  in_lane.heading_rad = Wrapped(pose.yaw_rad - middle_.yaw_rad - std::atan2(turned, inwards));
  return in_lane;
}

void LaneEstimate::Set(const Pose& pose, const InLane& in_lane) {
  const double yaw = pose.yaw_rad - in_lane.heading_rad;
  middle_ = {pose.x_m + in_lane.offset_m * std::sin(yaw),
             pose.y_m - in_lane.offset_m * std::cos(yaw), Wrapped(yaw)};
  curvature_per_m_ = in_lane.curvature_per_m;
  known_ = true;
}

void LaneEstimate::Straighten(const Pose& pose) {
  InLane now = At(pose);
  now.curvature_per_m = 0;
  Set(pose, now);
}

bool LaneEstimate::See(const Pose& pose, const SideLine& line, Side side, bool alone) {
  const InLane seen = InLaneBy(line, side, rules_.width_m);
  if (!known_) {
    Set(pose, seen);
    return true;
  }
  InLane now = At(pose);
  const double aside_m = seen.offset_m - now.offset_m;
  const double turned_rad = Wrapped(seen.heading_rad - now.heading_rad);
  int& jumps = side == Side::kLeft ? jumps_left_ : jumps_right_;
  const bool leads = side == Side::kLeft || alone;
  if (std::abs(aside_m) > rules_.jump_m || std::abs(turned_rad) > rules_.jump_rad) {
    if (++jumps < rules_.jumps || !leads) return false;
    jumps = 0;
    Set(pose, seen);
    return true;
  }
  jumps = 0;
  const double gain = (leads ? rules_.left_gain : rules_.right_gain) * line.quality;
  now.offset_m += gain * aside_m;
  now.heading_rad += gain * turned_rad;
  now.curvature_per_m +=
      gain * rules_.curvature_share * (seen.curvature_per_m - now.curvature_per_m);
  Set(pose, now);
  return true;
}

}  // namespace musher::line_walker
