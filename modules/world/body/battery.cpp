#include "musher/modules/world/body/battery.hpp"

#include <algorithm>

namespace musher::world {
namespace {

double DrainW(const BatterySpec& spec, Activity activity) {
  switch (activity) {
    case Activity::kOff:
      return spec.off_w;
    case Activity::kLying:
      return spec.lying_w;
    case Activity::kStanding:
      return spec.standing_w;
    case Activity::kMoving:
      return spec.moving_w;
  }
  return 0;
}

}  // namespace

void Battery::Step(Duration dt, Activity activity, bool on_pad) {
  constexpr double kSecondsInHour = 3600;
  const double seconds = ToSeconds(dt);
  charge_w_ = std::max(cable_ ? spec_.cable_w : 0, on_pad ? spec_.pad_w : 0);
  power_w_ = charge_w_ - DrainW(spec_, activity);
  const double whole_j = spec_.capacity_wh * kSecondsInHour;
  percent_ = std::clamp(percent_ + 100 * power_w_ * seconds / whole_j, 0.0, 100.0);
}

}  // namespace musher::world
