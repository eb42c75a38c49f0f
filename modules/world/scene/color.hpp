#pragma once
// Colours of pictures and of things.

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace musher::world {

struct Color {
  std::uint8_t red = 0, green = 0, blue = 0;

  friend bool operator==(const Color&, const Color&) = default;
};

// In OpenCV's order: cv::Scalar. A template, so that this header needs no OpenCV.
template <class Scalar>
Scalar Bgr(const Color& color) {
  return {double(color.blue), double(color.green), double(color.red)};
}

// From `a` to `b` by `share`, 0 to 1.
Color Mix(const Color& a, const Color& b, double share);

// "#rrggbb", or one of ColorNames().
std::optional<Color> ParseColor(std::string_view text);
std::vector<std::string_view> ColorNames();

}  // namespace musher::world
