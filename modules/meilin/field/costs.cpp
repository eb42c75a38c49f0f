#include "musher/modules/meilin/field/costs.hpp"

#include <cstdlib>

namespace musher::meilin {

double StepCosts::Move(int from_mm, int to_mm) const {
  constexpr int kLowStepMm = 300;  // the suspension lifts the robot to 205 mm up to here, then 410
  const int step_mm = to_mm - from_mm;
  if (step_mm == 0) return flat_s;
  const bool low = std::abs(step_mm) <= kLowStepMm;
  if (step_mm > 0) return low ? up_200_s : up_400_s;
  return low ? down_200_s : down_400_s;
}

}  // namespace musher::meilin
