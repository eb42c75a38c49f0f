#pragma once
// Follows the path that a body has come on back, by commands for a body that turns, and goes ahead
// and backwards: backwards, unless the path leads ahead of it, as where it came backwards; where
// the path leads to a side it turns on the spot first. Pure: what is in the way is the gate's.
//
// Metres, radians, seconds; poses in one frame, commands in that of the body. One thread.

#include <vector>

#include "musher/navigation/pose.hpp"

namespace musher::skills {

class WayBack {
 public:
  struct Speeds {
    double m_s = 0;
    double rad_s = 0;
  };

  // From `here`, at most `most_m` along `travelled`, whose newest pose is first
  // (Robot::travelled()).
  WayBack(const navigation::Pose& here, const navigation::Path& travelled, double most_m);

  // To its end; shorter than `most_m` where no more is known.
  double length_m() const { return places_.back().along_m; }
  // How far the body has come on it.
  double passed_m() const { return places_[passed_].along_m; }
  bool over() const;

  // The command at this pose; 0 at the end.
  navigation::Velocity Command(const navigation::Pose& body, const Speeds& speeds);
  // What is left, in the frame of a body at this pose: its places, each with the direction in which
  // the body goes on from there, that of the last one as before it.
  std::vector<navigation::Pose> Left(const navigation::Pose& body) const;

 private:
  struct Place {
    navigation::Point at;
    double along_m = 0;  // from the begin
  };

  std::size_t NextOf(std::size_t place, double ahead_m) const;

  std::vector<Place> places_;  // not empty
  std::size_t passed_ = 0;
  bool turning_ = false;
  bool ahead_ = false;
};

}  // namespace musher::skills
