#include "musher/test/modules/line_walker/s_lane.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "musher/messages/stamp.hpp"
#include "musher/modules/world/body/camera_model.hpp"

namespace musher::line_walker {
namespace {

constexpr Duration kStep = Milliseconds(10);
constexpr double kMost_m = 1.6;   // lines farther away are not detected
constexpr double kColumn_px = 3;  // half of what counts as one column
constexpr int kPeriods = 10;      // steps of 10 ms between pictures

Pose Arc(const Pose& from, double along_m, double radius_m) {
  const double turned = along_m / radius_m;
  const double x = radius_m * std::sin(turned);
  const double y = radius_m * (1 - std::cos(turned));
  return {from.x_m + x * std::cos(from.yaw_rad) - y * std::sin(from.yaw_rad),
          from.y_m + x * std::sin(from.yaw_rad) + y * std::cos(from.yaw_rad),
          from.yaw_rad + turned};
}

Pose Ahead(const Pose& from, double along_m) {
  return Moved(from, {along_m, 0, 0}, 1);
}

}  // namespace

world::CameraSpec SpecOf(const MountedCamera& camera) {
  world::CameraSpec spec;
  spec.model = camera.fisheye ? world::CameraModel::kFisheye : world::CameraModel::kPinhole;
  spec.position_m = {camera.x_m, camera.y_m, camera.z_m};
  spec.yaw_rad = camera.yaw_rad;
  spec.pitch_rad = camera.pitch_rad;
  spec.roll_rad = camera.roll_rad;
  spec.width_px = camera.width_px;
  spec.height_px = camera.height_px;
  spec.hfov_rad = camera.hfov_rad;
  return spec;
}

WorldCamera::WorldCamera(const MountedCamera& camera, const Pose& body, double height_m,
                         double roll_rad, double pitch_rad) {
  const world::CameraSpec spec = SpecOf(camera);
  world::Pose2 pose;
  pose.position_m = {body.x_m, body.y_m};
  pose.yaw_rad = body.yaw_rad;
  intrinsics_ = world::IntrinsicsOf(spec);
  X_CW_ = world::CameraInPlace(spec, pose, {height_m, roll_rad, pitch_rad}).inverse();
}

std::optional<std::array<double, 2>> WorldCamera::ShareOf(const GroundPoint& point) const {
  const auto pixel = world::Project(intrinsics_, X_CW_ * Eigen::Vector3d(point.x_m, point.y_m, 0));
  if (!pixel) return std::nullopt;
  const std::array share{(pixel->x() + 0.5) / intrinsics_.width_px,
                         (pixel->y() + 0.5) / intrinsics_.height_px};
  const bool inside = share[0] >= 0 && share[0] <= 1 && share[1] >= 0 && share[1] <= 1;
  return inside ? std::optional(share) : std::nullopt;
}

SLane::SLane(const Shape& shape)
    : shape_(shape),
      length_m_(shape.before_m + 2 * shape.radius_m * shape.arc_rad + shape.after_m) {
  for (double along = shape.lines_from_m; along <= length_m_; along += 0.008) {
    lines_.push_back({along, LinePoint(along, width_m / 2), LinePoint(along, -width_m / 2)});
  }
}

const SLane& TheSLane() {
  static const SLane lane;
  return lane;
}

Pose SLane::At(double along_m) const {
  const double arc_m = shape_.radius_m * shape_.arc_rad;
  if (along_m <= shape_.before_m) return {along_m, 0, 0};
  const Pose first{shape_.before_m, 0, 0};
  along_m -= shape_.before_m;
  if (along_m <= arc_m) return Arc(first, along_m, shape_.radius_m);
  const Pose second = Arc(first, arc_m, shape_.radius_m);
  along_m -= arc_m;
  if (along_m <= arc_m) return Arc(second, along_m, -shape_.radius_m);
  return Ahead(Arc(second, arc_m, -shape_.radius_m), along_m - arc_m);
}

SLane::Place SLane::PlaceOf(const Pose& body) const {
  Place nearest;
  double least = 1e9;
  const auto consider = [&](double along) {
    const Pose at = At(along);
    const double away = std::hypot(body.x_m - at.x_m, body.y_m - at.y_m);
    if (away >= least) return;
    least = away;
    nearest.along_m = along;
    nearest.left_m =
        std::cos(at.yaw_rad) * (body.y_m - at.y_m) - std::sin(at.yaw_rad) * (body.x_m - at.x_m);
  };
  for (double along = -0.5; along < length_m() + 1; along += 0.1) consider(along);
  const double about = nearest.along_m;
  for (double along = about - 0.1; along < about + 0.1; along += 0.005) consider(along);
  return nearest;
}

GroundPoint SLane::LinePoint(double along_m, double left_m) const {
  const Pose at = At(along_m);
  return {at.x_m - left_m * std::sin(at.yaw_rad), at.y_m + left_m * std::cos(at.yaw_rad)};
}

SLaneRun::SLaneRun(unsigned seed, double start_left_m, double start_heading_rad, WalkRules rules,
                   const SLane& course)
    : lane(course), walker(rules), rules_(rules), random_(seed) {
  body_ = {0, start_left_m, start_heading_rad};
  odometry_ = {3, -2, 1};
  SendOdometry();
  walker.Start(now_);
}

void SLaneRun::RunFor(Duration time) {
  for (const Time end = now_ + time; now_ < end;) Step();
}

void SLaneRun::RunToEnd(Duration longest) {
  for (const Time end = now_ + longest; now_ < end && walker.active();) Step();
  RunFor(Milliseconds(200));
}

void SLaneRun::Step() {
  now_ += kStep;
  ++ticks_;
  MoveBody(ToSeconds(kStep));
  if (ticks_ % 2 == 0) SendOdometry();
  if (ticks_ % kPeriods == 0 && has_cameras) TakePictures();
  while (!deliveries_.empty() && deliveries_.front().at <= now_) {
    const Delivery delivery = std::move(deliveries_.front());
    deliveries_.pop_front();
    walker.OnLines(delivery.view, delivery.lines, now_);
  }
  if (ticks_ % 5 != 0) return;
  if (const auto frame = walker.Tick(now_)) {
    frames.push_back(*frame);
    command_ = frame->velocity;
  }
  const SLane::Place at = place();
  if (!walker.active()) return;
  squares_ += at.left_m * at.left_m;
  ++samples_;
  max_m_ = std::max(max_m_, std::abs(at.left_m));
  if (at.along_m > 0.8) max_later_m_ = std::max(max_later_m_, std::abs(at.left_m));
}

void SLaneRun::MoveBody(double seconds) {
  const double share = seconds / ToSeconds(simulation.lag);
  if (ticks_ % kPeriods == 0) {
    noise_ = {Noise(simulation.speed_noise), Noise(simulation.speed_noise),
              Noise(simulation.speed_noise)};
  }
  const double kept = 1 - simulation.slip;
  velocity_.forward_m_s +=
      share * (command_.forward_m_s * kept * (1 + noise_.forward_m_s) - velocity_.forward_m_s);
  velocity_.left_m_s += share * (command_.left_m_s * kept + command_.forward_m_s * noise_.left_m_s -
                                 velocity_.left_m_s);
  velocity_.yaw_rad_s += share * (command_.yaw_rad_s * (1 - simulation.yaw_slip) +
                                  command_.forward_m_s * noise_.yaw_rad_s - velocity_.yaw_rad_s);
  body_ = Moved(body_, velocity_, seconds);
  Velocity measured = velocity_;
  measured.forward_m_s *= simulation.odometry_scale;
  measured.left_m_s *= simulation.odometry_scale;
  measured.yaw_rad_s += simulation.odometry_drift * velocity_.forward_m_s;
  odometry_ = Moved(odometry_, measured, seconds);
}

void SLaneRun::SendOdometry() {
  if (repeats_odometry) return walker.OnOdometry(last_odometry_, now_);
  msg::Odometry odometry;
  odometry.header.stamp = msg::ToStamp(now_.time_since_epoch());
  odometry.pose.pose.position = {odometry_.x_m, odometry_.y_m, 0.29};
  odometry.pose.pose.orientation.z = std::sin(odometry_.yaw_rad / 2);
  odometry.pose.pose.orientation.w = std::cos(odometry_.yaw_rad / 2);
  odometry.twist.twist.linear = {velocity_.forward_m_s, velocity_.left_m_s, 0};
  odometry.twist.twist.angular.z = velocity_.yaw_rad_s;
  last_odometry_ = odometry;
  walker.OnOdometry(odometry, now_);
}

void SLaneRun::TakePictures() {
  for (const View view : {View::kLeft, View::kRight, View::kFront}) {
    deliveries_.push_back({now_ + simulation.picture_delay, view, Picture(view)});
  }
}

// The front camera's edge is the lowest yellow pixel of each column, of whichever line.
msg::YellowLines SLaneRun::Picture(View view) {
  const CameraSet& cameras = rules_.cameras;
  const MountedCamera& camera = view == View::kLeft    ? cameras.left
                                : view == View::kRight ? cameras.right
                                                       : cameras.front;
  const WorldCamera shown(camera, body_, cameras.trunk_height_m, Noise(simulation.attitude_rad),
                          Noise(simulation.attitude_rad));
  std::vector<std::array<double, 2>> seen;
  const auto see = [&](const GroundPoint& point) {
    auto share = shown.ShareOf(point);
    if (!share) return;
    (*share)[0] += Noise(simulation.pixel_noise) / camera.width_px;
    (*share)[1] += Noise(simulation.pixel_noise) / camera.height_px;
    seen.push_back(*share);
  };
  const double from = place().along_m;
  const auto near = [&](const SLane::LinePoints& points, double place) {
    return points.along_m < place;
  };
  auto point = std::lower_bound(lane.lines().begin(), lane.lines().end(), from - kMost_m, near);
  for (; point != lane.lines().end() && point->along_m < from + kMost_m; ++point) {
    if (view != View::kRight) see(point->left);
    if (view != View::kLeft) see(point->right);
  }
  if (has_end_line && from + kMost_m > lane.length_m()) {
    for (double left = -0.4; left <= 0.4; left += 0.005) see(lane.LinePoint(lane.length_m(), left));
  }
  for (double left = 0.52; left <= 1.6 && has_lines_beside; left += 0.01) {
    see(lane.LinePoint(lane.length_m() + 0.07, left));
    see(lane.LinePoint(lane.length_m() + 0.07, -left));
  }
  std::map<int, std::array<double, 2>> lowest;
  const int columns = simulation.edge_columns;
  for (const auto& share : seen) {
    const int column = std::min(columns - 1, int(share[0] * columns));
    const double aside_px = std::abs(share[0] - (column + 0.5) / columns) * camera.width_px;
    if (share[1] < simulation.region_top || aside_px > kColumn_px) continue;
    const auto [found, added] = lowest.emplace(column, share);
    if (!added && share[1] > found->second[1]) found->second = share;
  }
  msg::YellowLines lines;
  lines.header.stamp = msg::ToStamp(now_.time_since_epoch());
  lines.contours = lowest.empty() ? 0 : 1;
  for (const auto& [column, share] : lowest) {
    lines.edge_x.push_back(float(share[0]));
    lines.edge_y.push_back(float(share[1]));
  }
  if (spoil) spoil(view, lines);
  return lines;
}

}  // namespace musher::line_walker
