#include "musher/modules/vision/picture/lens.hpp"

#include <algorithm>
#include <cmath>

#include "musher/modules/vision/picture/vision_code.hpp"

namespace musher::vision {
namespace {

constexpr double kWidest = 1e6;  // pixels; anything beyond is an error

bool IsLength(double px) {
  return px > 0 && px < kWidest;
}

}  // namespace

Result<Lens> LensOf(const msg::CameraInfo& info) {
  const auto error = [](const std::string& what) {
    return Error{VisionCode(KeyCode::kParametersInvalid), "CameraInfo: " + what};
  };
  if (info.width == 0 || info.height == 0) return error("it is of no size");
  if (!IsLength(info.k[0]) || !IsLength(info.k[4])) return error("it has no focal length");
  if (!IsLength(info.k[2]) || !IsLength(info.k[5])) return error("it has no centre");
  const double width = info.width;
  const double height = info.height;
  return Lens{info.distortion_model == msg::CameraInfo::kEquidistant, info.k[0] / width,
              info.k[4] / height, info.k[2] / width, info.k[5] / height};
}

Lens PinholeOf(double hfov_rad, std::uint32_t width_px, std::uint32_t height_px) {
  const double focal_x = 0.5 / std::tan(hfov_rad / 2);
  return {false, focal_x, focal_x * width_px / height_px, 0.5, 0.5};
}

double DistanceM(const Lens& lens, const FaceBox& box, double height, double face_m) {
  const double aside = (box.center_x() - lens.center_x) / lens.focal_x;
  const double down = (box.center_y() - lens.center_y) / lens.focal_y;
  if (lens.fisheye) {
    const double angle_rad = std::min(height / lens.focal_y, M_PI / 2);
    return face_m / 2 / std::tan(angle_rad / 2);
  }
  const double ahead_m = lens.focal_y * face_m / height;
  return ahead_m * std::sqrt(1 + aside * aside + down * down);
}

}  // namespace musher::vision
