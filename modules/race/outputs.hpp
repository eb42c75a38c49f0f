#pragma once
// The interface of the race to what it controls. Twists are in the body's frame, see course.hpp.
//
// Threads: called by the race, one at a time.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "musher/modules/race/course.hpp"

namespace musher::race {

// A frame of motion_servo_cmd.
struct ServoFrame {
  std::int32_t motion_id = 0;
  Twist twist;
  std::array<double, 2> step_height_m{};  // front and rear
  bool end = false;                       // cmd_type 2: the stream ends here

  friend bool operator==(const ServoFrame&, const ServoFrame&) = default;
};

class RaceOutputs {
 public:
  virtual ~RaceOutputs() = default;
  virtual void Walk(const ServoFrame& frame) = 0;  // each tick of a walk
  // One motion; Race::OnMotionDone() with this number follows.
  virtual void Move(std::int32_t motion_id, std::uint64_t number) = 0;
  virtual void CommandWalker(const LaneWalk& walk, bool start) = 0;
  // The detectors that are needed now, by their index; when they change.
  virtual void Watch(const std::vector<bool>& detectors) = 0;
  // Speaks; Race::OnSpoken() with this number follows.
  virtual void Speak(const std::string& text, std::uint64_t number) = 0;
  virtual void ShowState(int number) = 0;  // when it changes
  virtual void Log(const std::string& line) = 0;
};

}  // namespace musher::race
