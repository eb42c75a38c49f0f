#include "musher/modules/device/led_look.hpp"

namespace musher::device {
namespace {

using msg::LedExecute;

constexpr std::uint8_t kOff = 0;
// Of CyberDog: seven effects in each of three colours.
constexpr int kEffectsOfColor = 7;
constexpr std::uint8_t kRectangle = 0x33;
constexpr std::uint8_t kCentre = 0x34;
constexpr std::uint8_t kThreeCircles = 0x35;

// Of head and tail: the predefined colours of CyberDog.
constexpr std::array<std::array<std::uint8_t, 3>, 3> kColors = {
    {{255, 50, 50}, {44, 252, 255}, {255, 150, 0}}};  // red, blue, yellow

bool IsMini(std::uint8_t target) {
  return target == LedExecute::kMini;
}

// Of the mini light, which draws figures.
std::uint8_t MiniEffect(std::uint8_t effect) {
  switch (effect) {
    case LedExecute::kCircularBreath:
      return 0x01;
    case LedExecute::kCircularRing:
      return 0x02;
    case kRectangle:
      return 0x21;
    case kCentre:
      return 0x22;
    case kThreeCircles:
      return 0x23;
    case LedExecute::kColorOneByOne:
      return 0x24;
    default:
      return kOff;
  }
}

Duration HalfPeriod(std::uint8_t effect) {
  switch (effect) {
    case LedExecute::kBlink:
    case LedExecute::kBreathFast:
      return Milliseconds(500);
    case LedExecute::kBlinkFast:
      return Milliseconds(125);
    case LedExecute::kBreath:
      return Milliseconds(1000);
    default:
      return {};
  }
}

}  // namespace

Light WithoutPreset(const Light& light) {
  if (light.mode != LedExecute::kPredefined) return light;
  Light plain{LedExecute::kUserColor, kOff, 0, 0, 0};
  if (light.effect < LedExecute::kRedOn || light.effect > LedExecute::kYellowOneByOneFast) {
    return plain;
  }
  const int index = light.effect - LedExecute::kRedOn;
  const auto& color = kColors.at(static_cast<std::size_t>(index / kEffectsOfColor));
  plain.effect = static_cast<std::uint8_t>(LedExecute::kRgbOn + index % kEffectsOfColor);
  plain.r = color[0];
  plain.g = color[1];
  plain.b = color[2];
  return plain;
}

std::array<std::uint8_t, 4> BoardBytes(std::uint8_t target, const Light& light) {
  if (IsMini(target)) {
    const std::uint8_t effect = MiniEffect(light.effect);
    if (effect == kOff) return {};
    return {effect, light.r, light.g, light.b};
  }
  const Light plain = WithoutPreset(light);
  return {plain.effect, plain.r, plain.g, plain.b};
}

Look LookOf(std::uint8_t target, const Light& light) {
  if (IsMini(target)) {
    if (light.effect == LedExecute::kMiniOff) return {};
    const bool breathes = light.effect == LedExecute::kCircularBreath;
    return {light.r, light.g, light.b, breathes ? HalfPeriod(LedExecute::kBreath) : Duration()};
  }
  const Light plain = WithoutPreset(light);
  if (plain.effect == kOff) return {};
  return {plain.r, plain.g, plain.b, HalfPeriod(plain.effect)};
}

}  // namespace musher::device
