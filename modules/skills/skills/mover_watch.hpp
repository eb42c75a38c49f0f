#pragma once
// Whether what stands in the way of a robot has come there lately: a person who walks on, and not a
// thing. What its scan saw in the last seconds is kept, with the places from where it saw that.
//
// A place was free if it was seen then and nothing was near it. What is hidden, far away or outside
// of the scan was not seen: what appears there counts as a thing. Metres in the frame of the map.
// Pure; threads: one at a time.

#include <deque>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

class MoverWatch {
 public:
  // In each step, with the time since the last one.
  void Note(const Robot& robot, Duration step);
  // Whether most of these points, which the scan sees now, are at places that were free. False for
  // none.
  bool HaveCome(const Robot& robot, const std::vector<navigation::Point>& points) const;
  void Restart() { *this = {}; }

 private:
  struct Look {
    Duration at{};
    navigation::Pose from;
    std::vector<navigation::Point> seen;
  };

  bool WasFree(const Robot& robot, const Look& look, const navigation::Point& place) const;

  Duration now_{};
  std::deque<Look> looks_;
};

}  // namespace musher::skills
