#include "musher/modules/camera/camera_info.hpp"

#include <cmath>

namespace musher::camera {
namespace {

// A pixel's coordinate is that of its middle, so the left edge is at -0.5.
double Stretched(double centre, double factor) {
  return (centre + 0.5) * factor - 0.5;
}

}  // namespace

msg::CameraInfo Scaled(msg::CameraInfo info, std::uint32_t width_px, std::uint32_t height_px) {
  if (info.width == 0 || info.height == 0) return info;
  const double x = static_cast<double>(width_px) / info.width;
  const double y = static_cast<double>(height_px) / info.height;
  info.width = width_px;
  info.height = height_px;
  info.k[0] *= x;
  info.k[1] *= x;
  info.k[2] = Stretched(info.k[2], x);
  info.k[4] *= y;
  info.k[5] = Stretched(info.k[5], y);
  info.p[0] *= x;
  info.p[1] *= x;
  info.p[2] = Stretched(info.p[2], x);
  info.p[3] *= x;
  info.p[5] *= y;
  info.p[6] = Stretched(info.p[6], y);
  info.p[7] *= y;
  return info;
}

msg::CameraInfo Pinhole(std::uint32_t width_px, std::uint32_t height_px, double hfov_rad) {
  msg::CameraInfo info;
  info.width = width_px;
  info.height = height_px;
  info.distortion_model = msg::CameraInfo::kPlumbBob;
  info.d.assign(5, 0);
  const double f = width_px / 2.0 / std::tan(hfov_rad / 2);
  const double cx = (width_px - 1) / 2.0;
  const double cy = (height_px - 1) / 2.0;
  info.k = {f, 0, cx, 0, f, cy, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0};
  return info;
}

}  // namespace musher::camera
