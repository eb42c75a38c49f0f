#include "musher/navigation/gate/sample_age.hpp"

#include <algorithm>
#include <utility>

namespace musher::navigation {
namespace {

constexpr Duration kSampleClockSet = std::chrono::seconds(1);  // a larger step back
constexpr Duration kSampleAhead = Milliseconds(250);           // of the fastest one before
constexpr int kClockDrift = 5000;                              // one part in so many

}  // namespace

bool SampleAge::IsOfOtherClock(Duration stamp, Time now) const {
  if (!last_) return false;
  const bool ahead = now.time_since_epoch() - stamp < *offset_ - kSampleAhead;
  return ahead || stamp < last_->stamp - kSampleClockSet;
}

std::optional<Time> SampleAge::Take(Duration stamp, Time now) {
  if (stamp == Duration::zero()) return now;
  const std::optional<Stamped> other = std::exchange(other_, std::nullopt);
  if (IsOfOtherClock(stamp, now)) {
    other_ = Stamped{stamp, now};
    const Duration step = other ? stamp - other->stamp : Duration::zero();
    const bool follows = step > Duration::zero() && step <= now - other->at + kSampleAhead;
    if (!follows) return std::nullopt;
    Forget();
  }
  if (last_ && stamp <= last_->stamp) return std::nullopt;
  const Duration here = now.time_since_epoch() - stamp;
  offset_ = offset_ ? std::min(here, *offset_ + (now - last_->at) / kClockDrift) : here;
  last_ = Stamped{stamp, now};
  return now - (here - *offset_);
}

void SampleAge::Forget() {
  last_.reset();
  offset_.reset();
  other_.reset();
}

}  // namespace musher::navigation
