#include "musher/modules/world/lens.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

Lens::Lens(const CameraSpec& camera) : intrinsics_(IntrinsicsOf(camera)) {
  pixel_rad_ = static_cast<float>(1 / intrinsics_.focal_px);
  const auto count = static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
  for (auto* rays : {&rays_x_, &rays_y_, &rays_z_}) rays->reserve(count);
  gains_.reserve(count);
  // A fisheye ends at its circle, a pinhole in its corners.
  const double rim_px = camera.model == CameraModel::kFisheye
                            ? intrinsics_.focal_px * intrinsics_.farthest_rad
                            : Vector2d(width(), height()).norm() / 2;
  for (int y = 0; y < height(); ++y) {
    for (int x = 0; x < width(); ++x) {
      const Vector3d ray = RayOf(intrinsics_, {x, y});
      rays_x_.push_back(static_cast<float>(ray.x()));
      rays_y_.push_back(static_cast<float>(ray.y()));
      rays_z_.push_back(static_cast<float>(ray.z()));
      const double out = (Vector2d(x, y) - intrinsics_.center_px).norm() / rim_px;
      const bool seen = std::acos(std::clamp(ray.z(), -1.0, 1.0)) <= intrinsics_.farthest_rad;
      const double gain = camera.exposure * (1 - camera.vignette * out * out);
      gains_.push_back(seen ? static_cast<float>(std::max(gain, 0.0)) : 0);
    }
  }
  MakeTiles();
}

Vector3f Lens::Ray(int x, int y, float right, float down) const {
  const int beside = x + 1 < width() ? 1 : -1;
  const int below = y + 1 < height() ? 1 : -1;
  const Vector3f ray = Ray(x, y);
  const float across = right * static_cast<float>(beside);
  const float along = down * static_cast<float>(below);
  return (ray + across * (Ray(x + beside, y) - ray) + along * (Ray(x, y + below) - ray))
      .normalized();
}

void Lens::MakeTiles() {
  for (int y = 0; y < height(); y += kTilePx) {
    for (int x = 0; x < width(); x += kTilePx) {
      Tile tile;
      tile.x = x;
      tile.y = y;
      tile.end_x = std::min(x + kTilePx, width());
      tile.end_y = std::min(y + kTilePx, height());
      tile.axis = Ray((x + tile.end_x) / 2, (y + tile.end_y) / 2);
      float least_cosine = 1;
      tile.dark = true;
      for (int row = y; row < tile.end_y; ++row) {
        for (int column = x; column < tile.end_x; ++column) {
          least_cosine = std::min(least_cosine, tile.axis.dot(Ray(column, row)));
          tile.dark = tile.dark && Gain(column, row) <= 0;
        }
      }
      tile.half_angle_rad = std::acos(std::max(least_cosine, -1.0F)) + pixel_rad_;
      tiles_.push_back(tile);
    }
  }
}

}  // namespace musher::world
