#include "musher/lifecycle/health/health.hpp"

namespace musher {

std::string_view HealthName(Health health) {
  switch (health) {
    case Health::kStarved:
      return "starved";
    case Health::kHung:
      return "hung";
    case Health::kCrashed:
      return "crashed";
    case Health::kPartitioned:
      return "partitioned";
    case Health::kWell:
      break;
  }
  return "well";
}

Health EvaluateSilence(Duration silent, Duration allowance, Duration waited) {
  if (silent <= allowance) return Health::kWell;
  return silent - waited > allowance ? Health::kHung : Health::kStarved;
}

}  // namespace musher
