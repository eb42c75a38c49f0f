#pragma once
// The cameras of a scene: where they are mounted, and what their pictures are like. Metres and
// radians. Plain values without threads and errors.

#include <Eigen/Core>

namespace musher::world {

enum class CameraModel { kPinhole, kFisheye };

// What a camera is fixed to: the trunk, the head, which turns, or the place.
enum class CameraMount { kBody, kHead, kPlace };

// On the robot its position is from the middle of the trunk, x ahead, y to the left, z upwards,
// else from the place's origin; its angles turn it like the body's: yaw to the left, then pitch
// downwards, then roll.
struct CameraSpec {
  bool enabled = true;
  CameraMount on = CameraMount::kBody;
  CameraModel model = CameraModel::kPinhole;
  Eigen::Vector3d position_m{0, 0, 0};
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
  int width_px = 640;
  int height_px = 480;
  double hfov_rad = 0.98;  // angle from the left edge to the right one
  double rate_hz = 15;
  double noise = 1.5;      // standard deviation of each pixel, of 255
  double exposure = 1;     // factor on all light
  double vignette = 0.15;  // share of the light that is missing in the corners
};

}  // namespace musher::world
