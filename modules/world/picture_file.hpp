#pragma once
// Whether a file holds a picture that can be shown. The only question that reading a scene has to
// OpenCV.

#include <string>

#include "musher/lifecycle/result.hpp"

namespace musher::world {

inline constexpr int kMostPicturePx = 8192;  // on a side

// The error says what is wrong with it. Never throws.
Result<> CheckPicture(const std::string& path);

}  // namespace musher::world
