#pragma once
// Which of two robots that meet on one path goes first. Pure; any thread. Metres, the frame of the
// map.
//
//   one has no place to give way to, the other may have one  ──▶ it goes first
//   else the higher priority                                 ──▶ it goes first
//   else the lesser name                                     ──▶ it goes first
//
// Both robots decide for themselves, by what each says of itself, and by the same rule; so exactly
// one gives way. A robot that stands, or only crosses, is an obstacle and nothing more.

#include <optional>
#include <string>
#include <vector>

#include "musher/navigation/pose.hpp"

namespace musher::navigation {

// What a robot says of itself.
struct RobotIntent {
  std::string robot;      // "/dog/jetbot_0"
  int priority = 0;       // the higher one goes first
  double radius_m = 0.2;  // of its body
  bool flies = false;
  bool cornered = false;  // it finds no place to give way to
  Point at;
  std::vector<Point> path;  // that it drives, from `at` on; empty: it stands

  friend bool operator==(const RobotIntent&, const RobotIntent&) = default;
};

struct MeetingRules {
  double margin_m = 0.15;  // between two bodies that pass each other
  double look_m = 8;       // along both paths together
};

// The distance of their middles at which two bodies pass each other.
double KeptApart(double radius_m, double other_radius_m, const MeetingRules& rules);

bool GoesFirst(const RobotIntent& a, const RobotIntent& b);

// Where two robots that drive on would meet head-on: their paths lie on each other, in opposite
// directions, or each leads through the body of the other.
std::optional<Point> MeetingOf(const RobotIntent& own, const RobotIntent& other,
                               const MeetingRules& rules);

// The robots that it meets and that go first. `meets`: whether it meets any, also one that does
// not go first.
struct RightOfWay {
  std::vector<const RobotIntent*> first;  // of `others`
  bool meets = false;
};
RightOfWay RightOfWayOf(const RobotIntent& own, const std::vector<RobotIntent>& others,
                        const MeetingRules& rules);

// The path of a drive, as far as it is not driven yet.
class PathLeft {
 public:
  void Start(const Path& path);
  void Clear() { points_.clear(); }
  // From `at` on. It never goes back along the path.
  std::vector<Point> From(const Point& at);

 private:
  std::vector<Point> points_;
  std::size_t passed_ = 0;  // the begin of the line on which the robot is
  double passed_m_ = 0;     // of that line
};

}  // namespace musher::navigation
