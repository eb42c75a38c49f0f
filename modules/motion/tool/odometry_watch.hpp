#pragma once
// Detects missing odometry. A walk that depends on it soon stands still without it and gives up
// after a while; the first sample may take long, since its publisher may have to be discovered. It
// counts as missing only at a second check: after a late turn of the loop the first check runs
// before waiting samples have been read.

#include "musher/base/time.hpp"

namespace musher::motion::tool {

class OdometryWatch {
 public:
  OdometryWatch(Time begun, Duration until_first) : last_sample_(begun), allowed_(until_first) {}

  void OnSample(Time now) {
    last_sample_ = now;
    allowed_ = kLongest;
    missed_ = false;
  }

  // Too old to walk with.
  bool Old(Time now) const { return now - last_sample_ > kOld; }

  // Whether odometry is missing. Called once a turn of the loop.
  bool Missing(Time now) {
    const bool missed_before = missed_;
    missed_ = now - last_sample_ > allowed_;
    return missed_ && missed_before;
  }

 private:
  static constexpr Duration kOld = Milliseconds(500);
  static constexpr Duration kLongest = std::chrono::seconds(5);

  Time last_sample_;
  Duration allowed_;
  bool missed_ = false;
};

}  // namespace musher::motion::tool
