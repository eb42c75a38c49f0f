#pragma once
// Converts OpenCV's pictures, for the files that use OpenCV.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/world/paint/texture.hpp"

namespace cv {
class Mat;
}

namespace musher::world {

// Of a picture of 8 bits: blue, green, red.
Texture TextureOf(const cv::Mat& image);

// As PNG; the file is written completely or not at all.
Result<> SavePng(const cv::Mat& image, const std::string& path);

}  // namespace musher::world
