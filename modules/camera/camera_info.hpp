#pragma once
// CameraInfo for a picture of another size, and for a pinhole lens.

#include <cstdint>

#include "musher/messages/sensor_msgs/camera_info.hpp"

namespace musher::camera {

// The info for the same camera's picture, scaled to that size. An info without a size (the source
// has none) stays as it is.
msg::CameraInfo Scaled(msg::CameraInfo info, std::uint32_t width_px, std::uint32_t height_px);

// The info of a pinhole camera without distortion, square pixels, its axis through the middle.
// `hfov_rad` is the angle from the left edge to the right.
msg::CameraInfo Pinhole(std::uint32_t width_px, std::uint32_t height_px, double hfov_rad);

}  // namespace musher::camera
