#pragma once
// Whether the stamps of one source go on: a message that is repeated or late is refused. One that
// is a second or more older may be of a clock that was set back: that counts from its second
// message on. Pure; one thread.

#include <optional>
#include <utility>

#include "musher/base/time.hpp"

namespace musher::navigation {

class StampOrder {
 public:
  // `stamp`: of the message, since the zero of its clock; 0: it has none. False: it is refused.
  bool Take(Duration stamp) {
    if (stamp == Duration::zero()) return true;
    const std::optional<Duration> other = std::exchange(other_, std::nullopt);
    const bool goes_on = !last_ || stamp > *last_;
    const bool far_back = !goes_on && stamp <= *last_ - kSetBack;
    const bool set = far_back && other && stamp > *other;
    if (far_back) other_ = stamp;
    if (!goes_on && !set) return false;
    last_ = stamp;
    return true;
  }

 private:
  static constexpr Duration kSetBack = std::chrono::seconds(1);

  std::optional<Duration> last_;
  std::optional<Duration> other_;  // the last one, if it was so far back
};

}  // namespace musher::navigation
