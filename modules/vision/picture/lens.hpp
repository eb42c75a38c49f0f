#pragma once
// The distance of a face from its size in the picture. Pure.
//
// A face whose box is `face_m` high, and `h` pixels in the picture of a pinhole camera with the
// focal length `f` pixels, is f * face_m / h before the camera. An error of a tenth in the size, of
// the face or of its box, is one of a tenth in the distance.

#include <cstdint>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/modules/vision/picture/face_box.hpp"

namespace musher::vision {

// In units of the picture's own width and height, so that it fits a picture of any size.
struct Lens {
  bool fisheye = false;  // r = f theta; else r = f tan(theta)
  double focal_x = 0;
  double focal_y = 0;
  double center_x = 0.5;
  double center_y = 0.5;

  friend bool operator==(const Lens&, const Lens&) = default;
};

// Fails when the numbers are not those of a camera.
Result<Lens> LensOf(const msg::CameraInfo& info);

// A pinhole camera with square pixels and that angle from the left edge to the right.
Lens PinholeOf(double hfov_rad, std::uint32_t width_px, std::uint32_t height_px);

// From the camera to the face, in a straight line. `height`: of the box, instead of its own.
double DistanceM(const Lens& lens, const FaceBox& box, double height, double face_m);

}  // namespace musher::vision
