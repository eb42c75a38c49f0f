#pragma once
// All about a camera that stays the same from picture to picture: where each pixel looks, how much
// light it gets, and tiles of pixels with the cones they look into.
//
// Threads: never changed once it is made.

#include <Eigen/Core>
#include <vector>

#include "musher/modules/world/camera_model.hpp"

namespace musher::world {

class Lens {
 public:
  static constexpr int kTilePx = 32;

  struct Tile {
    int x = 0, y = 0, end_x = 0, end_y = 0;  // pixels
    Eigen::Vector3f axis;                    // in the camera's frame
    float half_angle_rad = 0;
    bool dark = false;  // nothing is seen in it
  };

  explicit Lens(const CameraSpec& camera);

  const Intrinsics& intrinsics() const { return intrinsics_; }
  int width() const { return intrinsics_.width_px; }
  int height() const { return intrinsics_.height_px; }
  const std::vector<Tile>& tiles() const { return tiles_; }
  // Of a pixel, of length 1.
  Eigen::Vector3f Ray(int x, int y) const {
    const std::size_t index = Index(x, y);
    return {rays_x_[index], rays_y_[index], rays_z_[index]};
  }
  // Of that pixel and those to its right, one coordinate of each.
  const float* RaysX(int x, int y) const { return &rays_x_[Index(x, y)]; }
  const float* RaysY(int x, int y) const { return &rays_y_[Index(x, y)]; }
  const float* RaysZ(int x, int y) const { return &rays_z_[Index(x, y)]; }
  // Of a place between pixels, in pixels from one.
  Eigen::Vector3f Ray(int x, int y, float right, float down) const;
  // Factor on the light of a pixel; 0 where the lens shows nothing.
  float Gain(int x, int y) const { return gains_[Index(x, y)]; }
  const float* Gains(int x, int y) const { return &gains_[Index(x, y)]; }
  // Angle between neighbouring pixels in the middle.
  float pixel_rad() const { return pixel_rad_; }

 private:
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(intrinsics_.width_px) +
           static_cast<std::size_t>(x);
  }
  void MakeTiles();

  Intrinsics intrinsics_;
  float pixel_rad_ = 0;
  std::vector<float> rays_x_, rays_y_, rays_z_;
  std::vector<float> gains_;
  std::vector<Tile> tiles_;
};

}  // namespace musher::world
