#pragma once
// Gives the points of a path a direction to look. Pure; any thread.

#include <vector>

#include "musher/navigation/pose.hpp"

namespace musher::navigation {

enum class Heading {
  kAlong,    // the body turns where it is, walks ahead, and turns at the goal
  kTurning,  // the body turns evenly on its way, for one that can move sideways
};

// `points` has at least one. The first pose has the yaw of `start_yaw_rad`, the last that of
// `goal_yaw_rad`; a turn where the body stands is two poses at one place.
Path WithHeadings(const std::vector<Point>& points, double start_yaw_rad, double goal_yaw_rad,
                  Heading heading);

}  // namespace musher::navigation
