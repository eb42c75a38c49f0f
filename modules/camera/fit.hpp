#pragma once
// Converts a picture to another size or encoding.
//
// Reentrant; the only file of the module's library that uses OpenCV's pictures.

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/camera/camera_config.hpp"

namespace musher::camera {

// Whether a picture can be read: a supported encoding (bgr8, rgb8, bgra8, rgba8, mono8), and as
// many bytes as its size needs. Fails with 4410.
Result<> CheckPicture(const msg::Image& picture);

// The same picture in `format`; moved through unchanged if it already has that format. Smaller
// pictures average over pixels, larger ones are interpolated.
Result<msg::Image> Fit(msg::Image picture, const Format& format);

}  // namespace musher::camera
