#pragma once
// Where on the ground the point of a picture lies, by the camera's model and its mount. Pure.
//
// Frame of the body: the origin on the ground below the middle of the trunk, x ahead, y to the
// left, in metres. The trunk is taken as level: a roll of 2 degrees moves a point beside the body
// by 3 cm. Pixels are shares of the picture: x to the right and y downwards from its left upper
// corner. Any thread.

#include <array>
#include <optional>

#include "musher/base/toml/rows.hpp"

namespace musher::navigation {

struct GroundPoint {
  double x_m = 0;
  double y_m = 0;

  friend bool operator==(const GroundPoint&, const GroundPoint&) = default;
};

// A fisheye has r = f theta, a pinhole r = f tan(theta); f by the angle from edge to edge.
struct MountedCamera {
  bool fisheye = false;
  double x_m = 0;  // from the middle of the trunk: ahead, to the left, up
  double y_m = 0;
  double z_m = 0;
  double yaw_rad = 0;    // to the left
  double pitch_rad = 0;  // downwards
  double roll_rad = 0;
  int width_px = 640;
  int height_px = 480;
  double hfov_rad = 1;

  friend bool operator==(const MountedCamera&, const MountedCamera&) = default;
};

// The keys of a mount in a config.
config_toml::Rows CameraRows(MountedCamera& camera);

// Nothing for a pixel outside the picture or the fisheye's circle, for the horizon and above it,
// for points farther than `farthest_m` from the body's origin, and for NaN.
std::optional<GroundPoint> OnGround(const MountedCamera& camera, double trunk_height_m,
                                    double farthest_m, double x_share, double y_share);

// The inverse: the share of the picture at which the camera shows a point on the ground; nothing
// for a point that it does not show.
std::optional<std::array<double, 2>> ShareOf(const MountedCamera& camera, double trunk_height_m,
                                             const GroundPoint& point);

}  // namespace musher::navigation
