#pragma once
// The path that a body has come on lately: for a way back along it. A body that goes back along it
// shortens it, so that the rest does not lead to and fro. Heights do not count. Pure; one thread.

#include <deque>

#include "musher/navigation/pose.hpp"

namespace musher::navigation {

class TravelledPath {
 public:
  static constexpr double kLongestM = 2;
  // From one pose to the next: a body does not move so far, its localisation has jumped.
  static constexpr double kJumpM = 0.5;

  // Where it is now, in one frame. After a jump the path begins again.
  void Add(const Pose& pose);

  // The newest pose first; each has the heading with which the body came to that place, 0.05 m or
  // a little more apart. Empty: none is known.
  Path Back() const { return {poses_.rbegin(), poses_.rend()}; }

 private:
  std::deque<Pose> poses_;  // the oldest first
  Pose last_;               // that was added
};

}  // namespace musher::navigation
