#include "musher/modules/meilin/servers/chassis_sensors.hpp"

#include <cmath>
#include <numeric>

namespace musher::meilin::servers {
namespace {

constexpr std::size_t kWindow = 5;

constexpr std::array<ClimbView, 4> kViews = {{
    {{0, 1, 2, 3}, {0, 1, 5, 4}},
    {{2, 0, 3, 1}, {2, 3, 7, 6}},
    {{1, 3, 0, 2}, {6, 7, 3, 2}},
    {{3, 2, 1, 0}, {4, 5, 1, 0}},
}};

}  // namespace

const ClimbView& ViewOf(ClimbDirection direction) {
  return kViews.at(static_cast<std::size_t>(direction));
}

void DistanceFilter::OnReading(double mm) {
  if (!std::isfinite(mm) || mm <= 0) return Clear();
  last_.push_back(mm);
  if (last_.size() > kWindow) last_.pop_front();
}

std::optional<double> DistanceFilter::mm() const {
  if (last_.size() < kWindow) return std::nullopt;
  return std::accumulate(last_.begin(), last_.end(), 0.0) / kWindow;
}

void SwitchFilter::OnReading(bool on) {
  if (last_ == on) on_ = on;
  last_ = on;
}

}  // namespace musher::meilin::servers
