#include "musher/modules/world/scene/color.hpp"

#include <charconv>
#include <cmath>
#include <utility>

namespace musher::world {
namespace {

constexpr std::pair<std::string_view, Color> kNames[] = {
    {"black", {24, 24, 26}},    {"white", {244, 244, 242}}, {"grey", {138, 140, 142}},
    {"red", {204, 36, 32}},     {"green", {32, 150, 60}},   {"blue", {32, 84, 190}},
    {"yellow", {246, 206, 20}}, {"orange", {240, 128, 24}}, {"purple", {124, 60, 168}},
    {"pink", {240, 130, 168}},  {"cyan", {20, 176, 196}},   {"brown", {122, 84, 52}},
    {"beige", {222, 206, 174}}, {"wood", {164, 118, 72}},   {"stone", {160, 154, 142}},
    {"grass", {96, 132, 58}},   {"leaf", {62, 104, 50}},    {"water", {64, 124, 156}},
};

std::uint8_t MixOne(std::uint8_t a, std::uint8_t b, double share) {
  return static_cast<std::uint8_t>(std::lround(a + (b - a) * share));
}

}  // namespace

Color Mix(const Color& a, const Color& b, double share) {
  return {MixOne(a.red, b.red, share), MixOne(a.green, b.green, share),
          MixOne(a.blue, b.blue, share)};
}

std::optional<Color> ParseColor(std::string_view text) {
  for (const auto& [name, color] : kNames) {
    if (text == name) return color;
  }
  constexpr std::size_t kHexLength = 7;
  if (text.size() != kHexLength || text[0] != '#') return std::nullopt;
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.begin() + 1, text.end(), number, 16);
  if (error != std::errc() || end != text.end()) return std::nullopt;
  const auto byte = [&](int shift) { return static_cast<std::uint8_t>(number >> shift & 0xFF); };
  return Color{byte(16), byte(8), byte(0)};
}

std::vector<std::string_view> ColorNames() {
  std::vector<std::string_view> names;
  for (const auto& [name, color] : kNames) names.push_back(name);
  return names;
}

}  // namespace musher::world
