#pragma once
// How a camera sees, as CameraInfo has it: of a picture in another size, and of a plain lens.

#include <cstdint>

#include "musher/messages/sensor_msgs/camera_info.hpp"

namespace musher::camera {

// Of the same camera's picture, scaled to that size. An info without a size (of a source that does
// not know) stays as it is.
msg::CameraInfo Scaled(msg::CameraInfo info, std::uint32_t width_px, std::uint32_t height_px);

// Of a pinhole camera without distortion, square pixels, its axis through the middle. `hfov_rad` is
// the angle from the left edge to the right.
msg::CameraInfo Pinhole(std::uint32_t width_px, std::uint32_t height_px, double hfov_rad);

}  // namespace musher::camera
