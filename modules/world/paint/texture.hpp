#pragma once
// A picture that is laid on a surface, also stored in successive half sizes, so that it does not
// flicker at a distance.
//
// Threads: immutable; any number of concurrent readers.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace musher::world {

// 0x00RRGGBB.
using Texel = std::uint32_t;

// The binary logarithm of a positive number, with an error of at most 0.09.
inline float RoughLog2(float value) {
  constexpr float kMantissa = 1.0F / (1U << 23);
  return static_cast<float>(std::bit_cast<std::int32_t>(value)) * kMantissa - 127;
}

class Texture {
 public:
  // `texels` row by row.
  Texture(int width, int height, std::vector<Texel> texels);

  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }
  // The mean of all texels.
  Texel mean() const { return levels_.back().texels.front(); }

  // At (x, y) in 256ths of a texel from the picture's corner; clamped to the edge outside.
  // `halvings` is the binary logarithm of how many texels a pixel covers along one side.
  Texel At(int x, int y, int halvings) const {
    const int level = std::clamp(halvings, 0, last_);
    return Sample(levels_[static_cast<std::size_t>(level)], x >> level, y >> level);
  }
  // Interpolated between levels; x and y in texels.
  Texel Smooth(float x, float y, float halvings) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<Texel> texels;
  };

  // Interpolated between the four texels around.
  static Texel Sample(const Level& level, int x, int y) {
    const int column = std::clamp(x - 128, 0, (level.width - 1) * 256);
    const int row = std::clamp(y - 128, 0, (level.height - 1) * 256);
    const int next = (column >> 8) + 1 < level.width ? 1 : 0;
    const int below = (row >> 8) + 1 < level.height ? level.width : 0;
    const Texel* at = level.texels.data() + std::ptrdiff_t{row >> 8} * level.width + (column >> 8);
    const auto right = static_cast<std::uint32_t>(column & 255);
    const auto down = static_cast<std::uint32_t>(row & 255);
    const std::uint32_t both = right * down >> 8;
    const Texel texels[] = {at[0], at[next], at[below], at[below + next]};
    const std::uint32_t weights[] = {256 - right - down + both, right - both, down - both, both};
    std::uint32_t outer = 0;  // red and blue, which do not meet: the weights make 256 together
    std::uint32_t inner = 0;
    for (int i = 0; i < 4; ++i) {
      outer += (texels[i] & 0xFF00FF) * weights[i];
      inner += (texels[i] >> 8 & 0xFF) * weights[i];
    }
    return (outer >> 8 & 0xFF00FF) | (inner & 0xFF00);
  }

  std::vector<Level> levels_;
  int last_ = 0;
};

}  // namespace musher::world
