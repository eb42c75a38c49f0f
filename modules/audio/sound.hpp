#pragma once
// Sound as it is made and played: samples of one channel.

#include <cstdint>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::audio {

struct Sound {
  int rate_hz = 22'050;
  std::vector<std::int16_t> samples;

  Duration Length() const {
    return std::chrono::nanoseconds(std::chrono::seconds(1)) *
           static_cast<std::int64_t>(samples.size()) / rate_hz;
  }
};

// `volume` in %.
constexpr std::int16_t Scaled(std::int16_t sample, int volume) {
  return static_cast<std::int16_t>(sample * volume / 100);
}

}  // namespace musher::audio
