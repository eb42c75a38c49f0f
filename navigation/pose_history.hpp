#pragma once
// Where a body was in the last second, by the stamps of its odometry: where a scan was taken, which
// comes later than its stamp says. Pure; one thread.

#include <deque>

#include "musher/base/time.hpp"
#include "musher/navigation/pose.hpp"
#include "musher/navigation/stamp_order.hpp"

namespace musher::navigation {

class PoseHistory {
 public:
  // `stamp`: of the message, since the zero of its clock; 0: it has none. False: the message is
  // repeated or late, and is not taken. A clock that was set begins again (stamp_order.hpp).
  bool Add(const Pose& pose, Duration stamp);
  void Clear() {
    poses_.clear();
    order_ = {};
  }

  bool empty() const { return poses_.empty(); }
  // The pose nearest in time; for a stamp of 0 the last one. Not if empty().
  const Pose& At(Duration stamp) const;

 private:
  struct Stamped {
    Duration stamp{};
    Pose pose;
  };
  std::deque<Stamped> poses_;
  StampOrder order_;
};

}  // namespace musher::navigation
