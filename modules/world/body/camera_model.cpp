#include "musher/modules/world/body/camera_model.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

}  // namespace

Intrinsics IntrinsicsOf(const CameraSpec& camera) {
  Intrinsics intrinsics;
  intrinsics.model = camera.model;
  intrinsics.width_px = camera.width_px;
  intrinsics.height_px = camera.height_px;
  intrinsics.center_px = {(camera.width_px - 1) / 2.0, (camera.height_px - 1) / 2.0};
  const double half = camera.hfov_rad / 2;
  const bool pinhole = camera.model == CameraModel::kPinhole;
  intrinsics.focal_px = camera.width_px / 2.0 / (pinhole ? std::tan(half) : half);
  intrinsics.farthest_rad = pinhole ? M_PI / 2 : half;
  return intrinsics;
}

std::optional<Vector2d> Project(const Intrinsics& intrinsics, const Vector3d& point_camera_m) {
  const Vector2d across = point_camera_m.head<2>();
  const double theta = std::atan2(across.norm(), point_camera_m.z());
  if (intrinsics.model == CameraModel::kPinhole) {
    if (point_camera_m.z() <= 0) return std::nullopt;
    return intrinsics.center_px + intrinsics.focal_px * across / point_camera_m.z();
  }
  if (theta > intrinsics.farthest_rad) return std::nullopt;
  const double norm = across.norm();
  if (norm == 0) return intrinsics.center_px;
  return intrinsics.center_px + intrinsics.focal_px * theta * across / norm;
}

Vector3d RayOf(const Intrinsics& intrinsics, const Vector2d& pixel) {
  const Vector2d across = (pixel - intrinsics.center_px) / intrinsics.focal_px;
  if (intrinsics.model == CameraModel::kPinhole) {
    return Vector3d(across.x(), across.y(), 1).normalized();
  }
  const double theta = std::min(across.norm(), M_PI);
  if (theta == 0) return Vector3d::UnitZ();
  const Vector2d aside = across.normalized() * std::sin(theta);
  return {aside.x(), aside.y(), std::cos(theta)};
}

Matrix3d Turned(double yaw_rad, double pitch_rad, double roll_rad) {
  return (AngleAxisd(yaw_rad, Vector3d::UnitZ()) * AngleAxisd(pitch_rad, Vector3d::UnitY()) *
          AngleAxisd(roll_rad, Vector3d::UnitX()))
      .toRotationMatrix();
}

Isometry3d BodyInPlace(const Pose2& body, const Attitude& attitude) {
  Isometry3d body_in_place = Isometry3d::Identity();
  body_in_place.linear() = Turned(body.yaw_rad, attitude.pitch_rad, attitude.roll_rad);
  body_in_place.translation() << body.position_m, attitude.height_m;
  return body_in_place;
}

Isometry3d CameraInPlace(const CameraSpec& camera, const Pose2& body, const Attitude& attitude,
                         const Gaze& gaze) {
  Matrix3d optical;  // its axes in a frame of x ahead, y to the left, z upwards
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Gaze turned = camera.on == CameraMount::kHead ? gaze : Gaze{};
  Isometry3d mount = Isometry3d::Identity();
  mount.linear() =
      Turned(camera.yaw_rad, camera.pitch_rad + turned.pitch_rad, camera.roll_rad) * optical;
  mount.translation() = camera.position_m;
  if (camera.on == CameraMount::kPlace) return mount;
  return BodyInPlace(body, attitude) * AngleAxisd(turned.yaw_rad, Vector3d::UnitZ()) * mount;
}

}  // namespace musher::world
