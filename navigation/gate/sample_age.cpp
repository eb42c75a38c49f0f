#include "musher/navigation/gate/sample_age.hpp"

#include <algorithm>

namespace musher::navigation {
namespace {

constexpr Duration kSampleClockSet = std::chrono::seconds(1);  // a larger step: the clock was set
constexpr int kClockDrift = 5000;                              // one part in so many

}  // namespace

bool SampleAge::IsNew(Duration stamp, Time now) {
  if (!last_stamp_) return true;
  const Duration step = stamp - *last_stamp_;
  if (step < -kSampleClockSet || step > now - last_at_ + kSampleClockSet) {
    offset_.reset();
    return true;
  }
  return step > Duration::zero();
}

std::optional<Time> SampleAge::Take(Duration stamp, Time now) {
  if (stamp == Duration::zero()) return now;
  if (!IsNew(stamp, now)) return std::nullopt;
  const Duration here = now.time_since_epoch() - stamp;
  offset_ = offset_ ? std::min(here, *offset_ + (now - last_at_) / kClockDrift) : here;
  last_stamp_ = stamp;
  last_at_ = now;
  return now - (here - *offset_);
}

void SampleAge::Forget() {
  last_stamp_.reset();
  offset_.reset();
}

}  // namespace musher::navigation
