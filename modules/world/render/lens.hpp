#pragma once
// Directions and light of the positions in a picture, like camera_model.hpp but for many at once;
// and tiles of the picture with the cones they cover.
//
// Threads: immutable.

#include <Eigen/Core>
#include <vector>

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/render/bundle.hpp"

namespace musher::world {

class Lens {
 public:
  static constexpr int kTilePx = static_cast<int>(kBundle);

  struct Tile {
    int x = 0, y = 0, end_x = 0, end_y = 0;  // pixels
    Eigen::Vector3f axis{0, 0, 1};           // in the camera's frame
    float half_angle_rad = 0;
    bool dark = false;  // no light comes through it
  };

  explicit Lens(const CameraSpec& camera);

  const Intrinsics& intrinsics() const { return intrinsics_; }
  int width() const { return intrinsics_.width_px; }
  int height() const { return intrinsics_.height_px; }
  const std::vector<Tile>& tiles() const { return tiles_; }
  // Angle between neighbouring pixels in the middle.
  float pixel_rad() const { return 1 / focal_px_; }

  // Leaves the dither alone. `gains` are factors on the light, 0 outside the lens's image.
  void Look(const Places& places, Rays& rays, Each<float>& gains) const;

 private:
  void MakeTile(Tile& tile) const;

  Intrinsics intrinsics_;
  float focal_px_ = 1;
  float exposure_ = 1;
  float vignette_ = 0;
  float rim2_ = 1;  // where the picture's corner or the fisheye's circle is, (r / f)^2
  std::vector<Tile> tiles_;
};

}  // namespace musher::world
