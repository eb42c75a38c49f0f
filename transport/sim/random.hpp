#pragma once
// The random generator of a simulation: splitmix64. The same seed gives the same numbers on every
// machine, unlike the distributions of the standard library. One statement draws one number: two
// draws in one expression come in an order that the compiler chooses.

#include <cstdint>

#include "musher/base/time.hpp"

namespace musher::transport::sim {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    state_ += 0x9e3779b97f4a7c15;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

  // True with `probability`; takes no sample if that is certain.
  bool Bernoulli(double probability) {
    if (probability <= 0) return false;
    if (probability >= 1) return true;
    constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
    return static_cast<double>(Next() >> 11) * kUnit < probability;
  }

  // A duration from `least` to `most`, both included.
  Duration Between(Duration least, Duration most) {
    if (most <= least) return least;
    const auto span = static_cast<std::uint64_t>((most - least).count()) + 1;
    return least + Duration(static_cast<std::int64_t>(Next() % span));
  }

 private:
  std::uint64_t state_;
};

}  // namespace musher::transport::sim
