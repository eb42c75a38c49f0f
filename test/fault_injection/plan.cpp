#include "musher/test/fault_injection/plan.hpp"

#include <algorithm>

namespace musher::fault_injection {

std::vector<PlannedFault> MakePlan(const std::vector<const Kind*>& kinds, int count,
                                   std::uint64_t seed) {
  std::vector<PlannedFault> plan;
  Random random(seed);
  std::vector<const Kind*> round;
  for (int i = 0; i < count && !kinds.empty(); ++i) {
    if (round.empty()) {
      round = kinds;
      random.Shuffle(round);
    }
    plan.push_back({round.back(), seed + static_cast<std::uint64_t>(i)});
    round.pop_back();
  }
  std::stable_sort(plan.begin(), plan.end(), [](const PlannedFault& a, const PlannedFault& b) {
    return a.kind->shape < b.kind->shape;
  });
  return plan;
}

}  // namespace musher::fault_injection
