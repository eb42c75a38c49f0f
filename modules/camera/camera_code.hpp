#pragma once
// The codes of the camera manager: module CameraServer (4400) and a key.

#include <cstdint>

#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::camera {

constexpr std::int32_t CameraCode(KeyCode key) {
  return MakeCode(cyberdog::module_code::kCameraServer, key);
}

}  // namespace musher::camera
