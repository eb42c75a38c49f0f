#pragma once
// A jaw that moves at its speed to the commanded width. On a real robot this class would drive a
// motor; here it computes the motion, so that the rest can be tested without hardware.

#include <algorithm>
#include <cmath>

#include "musher/base/time.hpp"

// [jaw]
class Jaw {
 public:
  Jaw(double width_mm, double speed_mm_s)
      : from_mm_(width_mm), to_mm_(width_mm), speed_mm_s_(speed_mm_s) {}

  void MoveTo(double width_mm, musher::Time now) {
    from_mm_ = WidthAt(now);
    to_mm_ = width_mm;
    since_ = now;
  }
  void Halt(musher::Time now) { MoveTo(WidthAt(now), now); }

  double WidthAt(musher::Time now) const {
    const double moved_mm = musher::ToSeconds(now - since_) * speed_mm_s_;
    const double way_mm = to_mm_ - from_mm_;
    return moved_mm >= std::abs(way_mm) ? to_mm_ : from_mm_ + std::copysign(moved_mm, way_mm);
  }
  bool MovesAt(musher::Time now) const { return WidthAt(now) != to_mm_; }

 private:
  double from_mm_;
  double to_mm_;
  double speed_mm_s_;
  musher::Time since_{};
};
// [jaw end]
