#pragma once
// A picture in another size or encoding.
//
// Reentrant; the only file of the module's library that knows OpenCV's pictures.

#include "musher/lifecycle/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/camera/camera_config.hpp"

namespace musher::camera {

// Whether a picture can be read at all: an encoding that is known here (bgr8, rgb8, bgra8, rgba8,
// mono8), and as many bytes as its size needs. Fails with 4410.
Result<> CheckPicture(const msg::Image& picture);

// The same picture as `format` wants it; moved through untouched where it is so already. Smaller
// pictures average over pixels, larger ones are interpolated.
Result<msg::Image> Fit(msg::Image picture, const Format& format);

}  // namespace musher::camera
