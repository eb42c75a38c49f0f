#pragma once
// The direction in which a round robot can drive between obstacles: a vector field histogram
// (VFH+). The directions around the robot are sectors of 5 degrees; an obstacle blocks those in
// which the robot, with a margin, would touch it. Of the free ones it takes the one that costs
// least by its angle to the wanted direction, to the present one and to the one chosen before.
//
// Metres and radians in the frame of the body: x forward, y to the left. Pure; any thread.

#include <optional>
#include <vector>

#include "musher/navigation/pose.hpp"

namespace musher::skills {

struct FieldRules {
  double radius_m = 0.2;  // of the robot
  double margin_m = 0.15;
  double range_m = 2;  // obstacles that are farther away do not count
};

// Nullopt: every direction is blocked. `before_rad`: the direction chosen before.
std::optional<double> FreeDirection(const std::vector<navigation::Point>& obstacles,
                                    double wanted_rad, double before_rad, const FieldRules& rules);

// How far the robot can go straight ahead until it is `kept_m` from an obstacle; at most `most_m`.
double FreeAhead(const std::vector<navigation::Point>& obstacles, double radius_m, double kept_m,
                 double most_m);

// The speed from which a robot can brake within `free_m`, after the time of a step.
double SafeSpeed(double free_m);

}  // namespace musher::skills
