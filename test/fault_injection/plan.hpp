#pragma once
// Which faults, in which order, with which draws: a function of the seed.

#include <cstdint>
#include <vector>

#include "musher/test/fault_injection/kind.hpp"

namespace musher::fault_injection {

struct PlannedFault {
  const Kind* kind = nullptr;
  std::uint64_t seed = 0;  // of its draws
};

// `count` faults of these kinds, each as often as the others, give or take one. A fault's own seed
// makes it the only one of a plan of one fault of its kind. Faults of the same shape of robot come
// together: a robot is reused.
std::vector<PlannedFault> MakePlan(const std::vector<const Kind*>& kinds, int count,
                                   std::uint64_t seed);

}  // namespace musher::fault_injection
