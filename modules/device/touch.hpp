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
