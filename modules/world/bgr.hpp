#pragma once
// Colours in OpenCV's format. Do not include it in headers: it needs OpenCV.

#include <opencv2/core.hpp>

#include "musher/modules/world/color.hpp"

namespace musher::world {

inline cv::Scalar Bgr(const Color& color) {
  return {double(color.blue), double(color.green), double(color.red)};
}

}  // namespace musher::world
