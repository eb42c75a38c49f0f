#pragma once
// A robot that meets another one head-on and has to give way: it brakes, drives to the nearest
// place that is off the paths of others, which is behind it in a corridor, and waits until its way
// is free.
//
//   brakes ──stands──▶ searches ──a place──▶ drives aside ──there──▶ waits
//                       │   ▲                    │                     │
//                no place   └── again after a while, or what is lost, or it is in the way there
//                       ▼
//                   cornered: it says so, and the others give way to it
//
// In each phase it ends once no robot that goes first is on its way any more. Polled in the steps
// of a skill. Frames and units of robot.hpp.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/modules/skills/skills/travel.hpp"

namespace musher::skills {

class GiveWay {
 public:
  // Both must outlive it.
  GiveWay(Robot& robot, Travel& travel) : robot_(robot), travel_(travel) {}

  // Whether a robot that goes first is on the way that is driven now.
  bool Needed();
  // Only after that. The drive is given up.
  void Begin();
  // The robot to which it gives way; empty: Begin() was not called.
  const std::string& to() const { return to_; }
  // "drives aside"
  std::string Doing() const;

  // True: the way is free, and the base as well.
  bool Step(Duration step);
  void Restart() { to_.clear(); }

  // "; /jetbot_1 is 0.6 m away": the nearest robot, where one is near enough to be what is in the
  // way.
  static std::string NearRobotText(const Robot& robot);

 private:
  enum class Phase : std::uint8_t { kBrakes, kSearches, kAside, kWaits, kCornered };

  bool WayIsFree();
  bool IsInTheWay() const;
  void Enter(Phase phase);
  void Search();
  void DriveAside(Duration step);

  Robot& robot_;
  Travel& travel_;
  Phase phase_ = Phase::kBrakes;
  Duration passed_{};  // in this phase
  Duration free_{};
  std::string to_;
  std::vector<navigation::Point> wanted_;  // the path that it would drive
  skill::Future<navigation::Path> refuge_;
};

}  // namespace musher::skills
