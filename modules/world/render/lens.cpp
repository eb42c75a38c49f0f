#include "musher/modules/world/render/lens.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::Vector3f;

// Of the square of an angle up to pi, to seven digits: the power series of cos(a) and sin(a) / a
// have even powers only.
float CosOfRoot(float a2) {
  constexpr float kOver[] = {1 / 2.F,   1 / 12.F,  1 / 30.F,  1 / 56.F, 1 / 90.F,
                             1 / 132.F, 1 / 182.F, 1 / 240.F, 1 / 306.F};  // 1 2, 3 4, 5 6, ...
  float sum = 1;
  for (int i = 8; i >= 0; --i) sum = 1 - a2 * kOver[i] * sum;
  return sum;
}
float SincOfRoot(float a2) {
  constexpr float kOver[] = {1 / 6.F,   1 / 20.F,  1 / 42.F,  1 / 72.F, 1 / 110.F,
                             1 / 156.F, 1 / 210.F, 1 / 272.F, 1 / 342.F};  // 2 3, 4 5, 6 7, ...
  float sum = 1;
  for (int i = 8; i >= 0; --i) sum = 1 - a2 * kOver[i] * sum;
  return sum;
}

}  // namespace

Lens::Lens(const CameraSpec& camera)
    : intrinsics_(IntrinsicsOf(camera)),
      focal_px_(static_cast<float>(intrinsics_.focal_px)),
      exposure_(static_cast<float>(camera.exposure)),
      vignette_(static_cast<float>(camera.vignette)) {
  const double rim = camera.model == CameraModel::kFisheye
                         ? intrinsics_.farthest_rad
                         : intrinsics_.center_px.norm() / intrinsics_.focal_px;
  rim2_ = static_cast<float>(rim * rim) * 1.0001F;  // the corner itself is in the picture
  for (int y = 0; y < height(); y += kTilePx) {
    for (int x = 0; x < width(); x += kTilePx) {
      Tile tile;
      tile.x = x;
      tile.y = y;
      tile.end_x = std::min(x + kTilePx, width());
      tile.end_y = std::min(y + kTilePx, height());
      MakeTile(tile);
      tiles_.push_back(tile);
    }
  }
}

void Lens::Look(const Places& places, Rays& rays, Each<float>& gains) const {
  const float each = 1 / focal_px_;
  const auto center_x = static_cast<float>(intrinsics_.center_px.x());
  const auto center_y = static_cast<float>(intrinsics_.center_px.y());
  const float vignette = vignette_ / rim2_;
  Each<float> out2;
  for (std::size_t i = 0; i < kBundle; ++i) {
    rays.x[i] = (places.x[i] - center_x) * each;
    rays.y[i] = (places.y[i] - center_y) * each;
    out2[i] = rays.x[i] * rays.x[i] + rays.y[i] * rays.y[i];
    gains[i] = out2[i] <= rim2_ ? exposure_ * (1 - vignette * out2[i]) : 0;
  }
  if (intrinsics_.model == CameraModel::kPinhole) {
    for (std::size_t i = 0; i < kBundle; ++i) {
      const float z = 1 / std::sqrt(1 + out2[i]);
      rays.x[i] *= z;
      rays.y[i] *= z;
      rays.z[i] = z;
    }
    return;
  }
  for (std::size_t i = 0; i < kBundle; ++i) {
    constexpr float kMost = 9.8696F;  // pi squared
    const float angle2 = out2[i] < kMost ? out2[i] : kMost;
    const float aside = SincOfRoot(angle2);
    rays.x[i] *= aside;
    rays.y[i] *= aside;
    rays.z[i] = CosOfRoot(angle2);
  }
}

void Lens::MakeTile(Tile& tile) const {
  std::vector<Vector3f> seen;
  Vector3f sum = Vector3f::Zero();
  Places places;
  Rays rays;
  Each<float> gains;
  for (int y = tile.y; y < tile.end_y; ++y) {
    for (std::size_t i = 0; i < kBundle; ++i) {
      places.x[i] = static_cast<float>(tile.x + static_cast<int>(i));
      places.y[i] = static_cast<float>(y);
    }
    Look(places, rays, gains);
    for (int i = 0; i < tile.end_x - tile.x; ++i) {
      if (gains[i] <= 0) continue;
      seen.emplace_back(rays.x[i], rays.y[i], rays.z[i]);
      sum += seen.back();
    }
  }
  tile.dark = seen.empty();
  if (tile.dark) return;
  tile.axis = sum.normalized();
  float least_cosine = 1;
  for (const Vector3f& ray : seen) least_cosine = std::min(least_cosine, tile.axis.dot(ray));
  tile.half_angle_rad = std::acos(std::max(least_cosine, -1.0F)) + pixel_rad();
}

}  // namespace musher::world
