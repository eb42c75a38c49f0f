#pragma once
// Converts OpenCV's pictures, for the files that use OpenCV.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/world/paint/texture.hpp"
#include "musher/modules/world/scene/color.hpp"

namespace cv {
class Mat;
}

namespace musher::world {

// A picture of 8 bits (blue, green, red) of one color. Mat's constructor with a color copies 12
// bytes at a time, which takes longer than drawing a place of millions of texels.
cv::Mat Plain(int rows, int cols, const Color& color);

// Of a picture of 8 bits: blue, green, red.
Texture TextureOf(const cv::Mat& image);

// As PNG; the file is written completely or not at all.
Result<> SavePng(const cv::Mat& image, const std::string& path);

}  // namespace musher::world
