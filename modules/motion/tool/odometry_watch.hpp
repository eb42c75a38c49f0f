#pragma once
// Whether odometry fails to come. Who walks by it stands still soon without it and gives up after a
// while; the first may take long, since who sends it may have to be found before. It is given up
// only at a second look: after a late turn the first look comes before what waits has been read.

#include "musher/lifecycle/time.hpp"

namespace musher::motion::tool {

class OdometryWatch {
 public:
  OdometryWatch(Time begun, Duration until_first) : heard_(begun), allowed_(until_first) {}

  void Heard(Time now) {
    heard_ = now;
    allowed_ = kLongest;
    missed_ = false;
  }

  // Too old to walk by.
  bool Old(Time now) const { return now - heard_ > kOld; }

  // Given up. To be asked once in a turn of the loop.
  bool Missing(Time now) {
    const bool missed_before = missed_;
    missed_ = now - heard_ > allowed_;
    return missed_ && missed_before;
  }

 private:
  static constexpr Duration kOld = Milliseconds(500);
  static constexpr Duration kLongest = std::chrono::seconds(5);

  Time heard_;
  Duration allowed_;
  bool missed_ = false;
};

}  // namespace musher::motion::tool
