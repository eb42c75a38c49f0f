#pragma once
// Follows the path that a body has come on back, backwards: by commands for a body that turns. The
// way ends where the body had come backwards or had turned around, and where it would lead more
// than kMostBendRad away from what is behind the body at the begin; it may have no length. So no
// command leads ahead: what is there, perhaps a person, is what the body makes room for. Pure: what
// is in the way is the gate's.
//
// Metres, radians, seconds; poses in one frame, commands in that of the body. One thread.

#include <vector>

#include "musher/navigation/pose.hpp"

namespace musher::skills {

class WayBack {
 public:
  static constexpr double kMostBendRad = 1;
  static constexpr double kEndM = 0.03;  // so near to its end it is over

  struct Speeds {
    double m_s = 0;
    double rad_s = 0;
  };

  // From `here`, at most `most_m` along `travelled`, whose newest pose is first
  // (Robot::travelled()).
  WayBack(const navigation::Pose& here, const navigation::Path& travelled, double most_m);

  // To its end; shorter than `most_m` where no more is known, or leads behind the body.
  double length_m() const { return places_.back().along_m; }
  // How far the body has come on it.
  double passed_m() const { return places_[passed_].along_m; }
  bool over() const { return passed_m() >= length_m() - kEndM; }
  // The way is no longer behind the body, or the body has turned away from how it has begun.
  bool lost() const { return lost_; }

  // The command at this pose; 0 at the end, and where it is lost.
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

  double begin_rad_ = 0;       // the heading of the body
  std::vector<Place> places_;  // not empty
  std::size_t passed_ = 0;
  bool lost_ = false;
};

}  // namespace musher::skills
