#pragma once
// Which faults, in which order, with which random numbers: a function of the seed.

#include <cstdint>
#include <vector>

#include "musher/test/fault_injection/kind.hpp"

namespace musher::fault_injection {

struct PlannedFault {
  const Kind* kind = nullptr;
  std::uint64_t seed = 0;  // of its random generator
};

// `count` faults of these kinds, each kind equally often, plus or minus one. A plan of one fault of
// its kind with a fault's own seed repeats that fault. Faults of the same shape of robot are
// adjacent, so that a robot is reused.
std::vector<PlannedFault> MakePlan(const std::vector<const Kind*>& kinds, int count,
                                   std::uint64_t seed);

}  // namespace musher::fault_injection
