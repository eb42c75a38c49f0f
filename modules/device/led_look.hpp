#pragma once
// What a light of the arbiter looks like: its effect and colour without the two modes, for lights
// that know CyberDog's effects and for those that only blink. Plain values, no IO.

#include <array>
#include <cstdint>

#include "musher/base/time.hpp"
#include "musher/modules/device/led.hpp"

namespace musher::device {

// A light of head or tail with one of the effects 1 to 9 (0: off) in a colour of its own.
Light WithoutPreset(const Light& light);

// The bytes of CyberDog's boards: the effect in their numbers, red, green, blue.
std::array<std::uint8_t, 4> BoardBytes(std::uint8_t target, const Light& light);

// Of a light that is on, off or blinks: a breathing one blinks slowly, one of running dots is on.
struct Look {
  std::uint8_t r = 0;  // all 0: off
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  Duration half_period{};  // of blinking; 0: on

  friend bool operator==(const Look&, const Look&) = default;
};
Look LookOf(std::uint8_t target, const Light& light);

}  // namespace musher::device
