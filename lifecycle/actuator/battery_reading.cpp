#include "musher/lifecycle/actuator/battery_reading.hpp"

#include <algorithm>

#include "musher/lifecycle/machine/policy_state.hpp"

namespace musher {

int BatteryReading::Take(std::uint64_t publisher, int percent, Time now) {
  publishers_[publisher] = {percent, now};
  std::erase_if(publishers_, [&](const auto& one) { return now - one.second.at >= silent_; });
  const auto lowest = std::min_element(
      publishers_.begin(), publishers_.end(),
      [](const auto& a, const auto& b) { return a.second.percent < b.second.percent; });
  const int reported = lowest->second.percent;
  if (!percent_ || reported <= *percent_) {
    rise_.reset();
    percent_ = reported;
    return reported;
  }
  if (!rise_) rise_ = Rise{reported, now, 0};
  rise_->lowest = std::min(rise_->lowest, reported);
  ++rise_->samples;
  if (rise_->samples >= kConfirmingSamples && now - rise_->since >= raise_after_) {
    percent_ = rise_->lowest;
    rise_.reset();
  }
  return *percent_;
}

void BatteryReading::Forget() {
  publishers_.clear();
  percent_.reset();
  rise_.reset();
}

}  // namespace musher
