#include "musher/navigation/camera/mounted_camera.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHorizon = 0.05;  // downward part of a ray of length 1; less shows no near ground

// In the camera's frame: x to the right of the picture, y down, z ahead.
std::optional<Vector3d> RayThrough(const MountedCamera& camera, const Vector2d& from_center_px) {
  const double half = camera.hfov_rad / 2;
  const double focal_px = camera.width_px / 2.0 / (camera.fisheye ? half : std::tan(half));
  const Vector2d across = from_center_px / focal_px;
  if (!camera.fisheye) return Vector3d(across.x(), across.y(), 1).normalized();
  const double theta = across.norm();
  if (theta > half) return std::nullopt;
  if (theta == 0) return Vector3d(Vector3d::UnitZ());
  const Vector2d aside = across * (std::sin(theta) / theta);
  return Vector3d(aside.x(), aside.y(), std::cos(theta));
}

// From the camera's frame to the body's.
Matrix3d RotationOf(const MountedCamera& camera) {
  Matrix3d optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return AngleAxisd(camera.yaw_rad, Vector3d::UnitZ()) *
         AngleAxisd(camera.pitch_rad, Vector3d::UnitY()) *
         AngleAxisd(camera.roll_rad, Vector3d::UnitX()) * optical;
}

}  // namespace

config_toml::Rows CameraRows(MountedCamera& camera) {
  namespace row = config_toml::row;
  constexpr double kWidestPinholeRad = 170 * M_PI / 180;
  return {
      row::Choice("model", camera.fisheye, {{"pinhole", false}, {"fisheye", true}}),
      row::Number("x_m", camera.x_m, -2, 2),
      row::Number("y_m", camera.y_m, -2, 2),
      row::Number("z_m", camera.z_m, -2, 2),
      row::Degrees("yaw_deg", camera.yaw_rad, -360, 360),
      row::Degrees("pitch_deg", camera.pitch_rad, -90, 90),
      row::Degrees("roll_deg", camera.roll_rad, -180, 180),
      row::Integer("width_px", camera.width_px, 8, 8192),
      row::Integer("height_px", camera.height_px, 8, 8192),
      row::Degrees("hfov_deg", camera.hfov_rad, 1, 220),
      row::Check(
          "hfov_deg", [&] { return camera.fisheye || camera.hfov_rad < kWidestPinholeRad; },
          "a pinhole has less than 170 degrees"),
  };
}

std::optional<GroundPoint> OnGround(const MountedCamera& camera, double trunk_height_m,
                                    double farthest_m, double x_share, double y_share) {
  const bool inside = x_share >= 0 && x_share <= 1 && y_share >= 0 && y_share <= 1;
  if (!inside) return std::nullopt;  // NaN is not inside
  const Vector2d from_center_px((x_share - 0.5) * camera.width_px,
                                (y_share - 0.5) * camera.height_px);
  const auto seen = RayThrough(camera, from_center_px);
  if (!seen) return std::nullopt;
  const Vector3d ray = RotationOf(camera) * *seen;
  if (ray.z() > -kHorizon) return std::nullopt;
  const double length = (trunk_height_m + camera.z_m) / -ray.z();
  const GroundPoint point{camera.x_m + length * ray.x(), camera.y_m + length * ray.y()};
  if (length <= 0 || std::hypot(point.x_m, point.y_m) > farthest_m) return std::nullopt;
  return point;
}

std::optional<std::array<double, 2>> ShareOf(const MountedCamera& camera, double trunk_height_m,
                                             const GroundPoint& point) {
  const Vector3d seen =
      RotationOf(camera).transpose() *
      Vector3d(point.x_m - camera.x_m, point.y_m - camera.y_m, -trunk_height_m - camera.z_m);
  const double half = camera.hfov_rad / 2;
  const double focal_px = camera.width_px / 2.0 / (camera.fisheye ? half : std::tan(half));
  const double across = std::hypot(seen.x(), seen.y());
  const double theta = std::atan2(across, seen.z());
  if (across == 0 || theta > (camera.fisheye ? half : M_PI / 2 - kHorizon)) return std::nullopt;
  const double radius_px = focal_px * (camera.fisheye ? theta : std::tan(theta));
  const std::array share{0.5 + radius_px * seen.x() / across / camera.width_px,
                         0.5 + radius_px * seen.y() / across / camera.height_px};
  const bool inside = share[0] >= 0 && share[0] <= 1 && share[1] >= 0 && share[1] <= 1;
  return inside ? std::optional(share) : std::nullopt;
}

}  // namespace musher::navigation
