#include "musher/lifecycle/health/health.hpp"

namespace musher {

std::string_view HealthName(Health health) {
  return fields::NameOf(health);
}

Health EvaluateSilence(Duration silent, Duration allowance, Duration waited) {
  if (silent <= allowance) return Health::kWell;
  return silent - waited > allowance ? Health::kHung : Health::kStarved;
}

}  // namespace musher
