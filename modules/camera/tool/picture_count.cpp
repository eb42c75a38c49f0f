#include "musher/modules/camera/tool/picture_count.hpp"
#include "musher/messages/stamp.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace musher::camera::tool {

void PictureCount::Add(const msg::Image& picture, Duration age, Time now) {
  if (ages_ms_.empty()) first_ = now;
  last_ = now;
  shape_ = std::to_string(picture.width) + "x" + std::to_string(picture.height) + " " +
           picture.encoding.substr(0, 16);
  ages_ms_.push_back(std::chrono::duration<double, std::milli>(age).count());
  stamps_ns_.push_back(msg::FromStamp(picture.header.stamp).count());
}

double PictureCount::RateHz() const {
  const double seconds = ToSeconds(last_ - first_);
  return seconds > 0 ? static_cast<double>(count() - 1) / seconds : 0;
}

double PictureCount::AgeMs(double share) const {
  if (ages_ms_.empty()) return 0;
  std::vector<double> ages = ages_ms_;
  const auto at = std::lround(share * static_cast<double>(ages.size() - 1));
  std::nth_element(ages.begin(), ages.begin() + at, ages.end());
  return ages[at];
}

std::uint64_t PictureCount::Lost() const {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < stamps_ns_.size(); ++i) {
    steps.push_back(stamps_ns_[i] - stamps_ns_[i - 1]);
  }
  if (steps.empty()) return 0;
  std::vector<std::int64_t> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  if (*middle <= 0) return 0;
  std::uint64_t lost = 0;
  for (const std::int64_t step : steps) {
    const double periods = static_cast<double>(step) / static_cast<double>(*middle);
    if (periods > 1.5) lost += static_cast<std::uint64_t>(std::lround(periods)) - 1;
  }
  return lost;
}

}  // namespace musher::camera::tool
