#include "musher/modules/world/paint/texture.hpp"

#include <cmath>
#include <utility>

#include "musher/base/check.hpp"

namespace musher::world {
namespace {

Texel MeanOf(Texel a, Texel b, Texel c, Texel d) {
  Texel mean = 0;
  for (const int shift : {0, 8, 16}) {
    const auto part = [shift](Texel texel) { return texel >> shift & 0xFF; };
    mean |= (part(a) + part(b) + part(c) + part(d) + 2) / 4 << shift;
  }
  return mean;
}

// Between two texels by `share` of 256.
Texel Between(Texel a, Texel b, std::uint32_t share) {
  const std::uint32_t rest = 256 - share;
  const std::uint32_t outer = (a & 0xFF00FF) * rest + (b & 0xFF00FF) * share;
  const std::uint32_t inner = (a >> 8 & 0xFF) * rest + (b >> 8 & 0xFF) * share;
  return (outer >> 8 & 0xFF00FF) | (inner & 0xFF00);
}

}  // namespace

Texture::Texture(int width, int height, std::vector<Texel> texels) {
  MUSHER_CHECK(width > 0 && height > 0);
  MUSHER_CHECK(texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  levels_.push_back({width, height, std::move(texels)});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& large = levels_.back();
    Level half{(large.width + 1) / 2, (large.height + 1) / 2, {}};
    half.texels.reserve(static_cast<std::size_t>(half.width) *
                        static_cast<std::size_t>(half.height));
    for (int y = 0; y < half.height; ++y) {
      const Texel* upper = large.texels.data() + std::ptrdiff_t{2} * y * large.width;
      const Texel* lower = 2 * y + 1 < large.height ? upper + large.width : upper;
      for (int x = 0; x < half.width; ++x) {
        const int right = std::min(2 * x + 1, large.width - 1);
        half.texels.push_back(MeanOf(upper[2 * x], upper[right], lower[2 * x], lower[right]));
      }
    }
    levels_.push_back(std::move(half));
  }
  last_ = static_cast<int>(levels_.size()) - 1;
}

Texel Texture::Smooth(float x, float y, float halvings) const {
  const float level = std::clamp(halvings, 0.0F, static_cast<float>(last_));
  const int lower = static_cast<int>(level);
  const auto share = static_cast<std::uint32_t>((level - static_cast<float>(lower)) * 256);
  const int column = static_cast<int>(x * 256);
  const int row = static_cast<int>(y * 256);
  return Between(At(column, row, lower), At(column, row, lower + 1), share);
}

}  // namespace musher::world
