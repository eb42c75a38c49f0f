#pragma once
// Whether a file holds a readable picture. The only use of OpenCV while a scene is read.

#include <string>

#include "musher/base/result.hpp"

namespace musher::world {

inline constexpr int kMostPicturePx = 8192;  // on a side

// The error describes the fault. Never throws.
Result<> CheckPicture(const std::string& path);

}  // namespace musher::world
