#pragma once
// Where a camera is and which direction each pixel has. Pure.
//
// The camera's own frame is the optical one of ROS: x to the right of the picture, y down, z ahead.
// Whole numbers are the middles of pixels: (0, 0) is that of the upper left one.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "musher/modules/world/body/body.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// The same numbers that CameraInfo publishes.
struct Intrinsics {
  CameraModel model = CameraModel::kPinhole;
  int width_px = 0;
  int height_px = 0;
  double focal_px = 0;  // pinhole: r = f tan(theta); fisheye: r = f theta
  Eigen::Vector2d center_px{0, 0};
  double farthest_rad = 0;  // from the axis; a fisheye sees nothing beyond
};
Intrinsics IntrinsicsOf(const CameraSpec& camera);

// Nothing for a point that the model cannot show, behind a pinhole or beyond a fisheye's circle.
// The pixel may lie outside the picture.
std::optional<Eigen::Vector2d> Project(const Intrinsics& intrinsics,
                                       const Eigen::Vector3d& point_camera_m);

// Of length 1, in the camera's frame. The inverse of Project().
Eigen::Vector3d RayOf(const Intrinsics& intrinsics, const Eigen::Vector2d& pixel);

// The angles of a head from straight ahead.
struct Gaze {
  double yaw_rad = 0;    // to the left
  double pitch_rad = 0;  // downwards
};

// The rotation by these angles: first roll about x, then pitch about y, then yaw about z.
Eigen::Matrix3d Turned(double yaw_rad, double pitch_rad, double roll_rad);

// The body's frame in the place's.
Eigen::Isometry3d BodyInPlace(const Pose2& body, const Attitude& attitude);

// The camera's frame in the place's, for a body at that pose. X_WC p_C = p_W. The gaze turns
// cameras on the head: by its yaw about the body's upright axis, by its pitch about the camera. A
// camera mounted in the place does not move.
Eigen::Isometry3d CameraInPlace(const CameraSpec& camera, const Pose2& body,
                                const Attitude& attitude, const Gaze& gaze = {});

}  // namespace musher::world
