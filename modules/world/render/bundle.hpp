#pragma once
// Rays that are traced together, so that the compiler can vectorise over several at once.

#include <array>
#include <cstdint>

namespace musher::world {

inline constexpr std::size_t kBundle = 32;

// One number for each ray of a bundle.
template <typename T>
using Each = std::array<T, kBundle>;

// Positions in the picture; whole numbers are the middles of pixels.
struct Places {
  Each<float> x, y;
};

// Directions of length 1 in the camera's frame.
struct Rays {
  Each<float> x, y, z;
  Each<float> dither;  // 0 to 1: hides the borders between coarser and finer ground
};

// What the rays see. Neighbours on one surface have the same number, which is not 0.
struct Sights {
  Each<std::uint16_t> surface;
  Each<float> red, green, blue;  // 255 is white
};

}  // namespace musher::world
