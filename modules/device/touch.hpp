#pragma once
// Which touches of the robot's pad are known, and which one wakes it. Plain values, no IO.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/base/time.hpp"

namespace musher::device {

// "double tap"; empty: an unknown touch.
std::string TouchText(std::int32_t touch_state);
inline bool IsTouch(std::int32_t touch_state) {
  return !TouchText(touch_state).empty();
}

// What the touches of a pad are that reports only whether it is touched: a hold once it is touched
// for 800 ms, a double tap when the second of two taps within 300 ms ends, else a single tap.
class Taps {
 public:
  static constexpr Duration kHold = Milliseconds(800);
  static constexpr Duration kBetween = Milliseconds(300);

  // A touch_state, once it is known.
  std::optional<std::int32_t> OnTouch(bool touched, Time now);
  std::optional<std::int32_t> OnTime(Time now);
  // When to call OnTime().
  std::optional<Time> NextDeadline() const;
  // What was begun is none: events are missing.
  void Forget() { *this = {}; }

 private:
  std::optional<Time> touched_at_;
  bool held_ = false;           // reported
  std::optional<Time> tap_at_;  // the end of a first tap
};

// A double tap counts at least 2 s after the last one that counted.
class DoubleTap {
 public:
  static constexpr Duration kPause = Milliseconds(2000);

  bool Take(std::int32_t touch_state, Time now);
  void Forget() { last_.reset(); }  // the clock has jumped

 private:
  std::optional<Time> last_;
};

}  // namespace musher::device
