#include "musher/modules/line_walker/ground.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace musher::line_walker {
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

GroundPoints EdgeOnGround(const MountedCamera& camera, double trunk_height_m, double farthest_m,
                          const msg::YellowLines& lines, std::size_t most) {
  GroundPoints all;
  const std::size_t count = std::min(lines.edge_x.size(), lines.edge_y.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto point =
        OnGround(camera, trunk_height_m, farthest_m, lines.edge_x[i], lines.edge_y[i]);
    if (point) all.push_back(*point);
  }
  if (all.size() <= most) return all;
  GroundPoints chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(all[i * all.size() / most]);
  return chosen;
}

}  // namespace musher::line_walker
