#pragma once
// Faces and times for tests.

#include <chrono>
#include <vector>

#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/vision/picture/face_box.hpp"
#include "musher/modules/vision/picture/lens.hpp"

namespace musher::vision {

inline constexpr std::int64_t kMs = 1'000'000;

// A square one in a picture of 4:3, around that centre.
inline FaceBox FaceAt(double center_x, double center_y, double height = 0.2) {
  const double width = height * 3 / 4;
  return {center_x - width / 2, center_y - height / 2, width, height, true, 0.9};
}

inline FaceBox TurnedAway(FaceBox face) {
  face.frontal = false;
  return face;
}

// As the world's front camera: 640 x 480, focal length 600 px.
inline msg::CameraInfo FrontInfo() {
  msg::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = msg::CameraInfo::kPlumbBob;
  info.k = {600, 0, 319.5, 0, 600, 239.5, 0, 0, 1};
  return info;
}

inline Lens FrontLens() {
  return LensOf(FrontInfo()).value();
}

// How high the box of a face of `face_m` is in the front camera, straight ahead.
inline double HeightAt(double distance_m, double face_m) {
  return 600 * face_m / distance_m / 480;
}

inline msg::Image Picture(std::uint32_t width = 64, std::uint32_t height = 48) {
  msg::Image picture;
  picture.width = width;
  picture.height = height;
  picture.encoding = "bgr8";
  picture.step = width * 3;
  picture.data.assign(std::size_t{picture.step} * height, 7);
  return picture;
}

}  // namespace musher::vision
