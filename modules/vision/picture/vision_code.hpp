#pragma once
// The codes of the vision manager: module Face (5900) and a key.

#include <cstdint>

#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::vision {

constexpr std::int32_t VisionCode(KeyCode key) {
  return MakeCode(cyberdog::module_code::kFace, key);
}

}  // namespace musher::vision
