#pragma once
// Places along a path, by their distance from its begin in m; only for the nodes of this folder.
//
// Paths of our planners have poses only where they turn: what is near a robot lies between two.

#include <limits>

#include "musher/behavior/tree/nav2/robot.hpp"

namespace musher::tree::nav2 {

// What lies from `from_m` to `until_m` along the path, which has poses.
Path Part(const Path& path, double from_m, double until_m);

// The path up to where it comes within `distance_m` of its end, and looks at that end there.
Path EndingBefore(Path path, double distance_m);

// How well a robot at `pose`, `along_m` along the path, keeps to it. `path` has poses; no heights.
Tracking TrackingAt(const Path& path, const Pose& pose, double along_m);

// How far along its path a robot is. With a limit, the place is sought from where it was found last
// on the same path, and no farther than `search_m` from there: so a path may cross itself.
class PathProgress {
 public:
  static constexpr double kNoLimit = std::numeric_limits<double>::infinity();

  // The nearest place of the path, which has poses; `m_per_rad`: what a difference in direction
  // counts.
  double Along(const Robot& robot, const Path& path, const Pose& pose, double search_m,
               double m_per_rad = 0);

 private:
  Path path_;
  double found_m_ = 0;
};

}  // namespace musher::tree::nav2
