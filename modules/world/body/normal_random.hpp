#pragma once
// Normally distributed random numbers that are the same for the same seed on every machine.

#include "musher/transport/sim/random.hpp"

namespace musher::world {

class NormalRandom {
 public:
  explicit NormalRandom(std::uint64_t seed) : random_(seed) {}

  // Mean 0, standard deviation 1, never beyond 6: twelve uniform numbers added up.
  double Normal() {
    constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random_.Next() >> 11) * kUnit;
    return sum;
  }

 private:
  transport::sim::Random random_;
};

}  // namespace musher::world
