#pragma once
// Keeps a flyer at a place against wind: a proportional controller of x, y, z and yaw, with an
// integral part that learns a steady wind within a few seconds.
//
// Metres, radians, seconds; poses in the frame of the map, commands in the frame of the body. Any
// thread. Gains are tuned for a body whose velocity follows its command within about 0.3 s, and for
// 10 steps in a second.

#include <algorithm>
#include <optional>

#include "musher/base/time.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::skills {

class PositionHold {
 public:
  // No command is faster, horizontally and vertically.
  static constexpr double kSpeedMps = 0.5;
  static constexpr double kYawRateRadS = 0.5;

  // The seconds of a step, for a controller: a jump of the clock and the end of a pause are no
  // wind.
  static double SecondsOf(Duration step) { return std::min(ToSeconds(step), 0.2); }

  // The command towards `place`, `step_s` after the last one.
  navigation::Velocity Command(const navigation::Pose& place, const navigation::Pose& now,
                               double step_s);
  // Forgets the wind.
  void Reset() {
    wind_ = {};
    last_error_.reset();
  }

 private:
  navigation::Point wind_;  // the velocity, in the map, that balances it
  std::optional<navigation::Point> last_error_;
};

}  // namespace musher::skills
