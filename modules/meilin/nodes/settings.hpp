#pragma once
// What the nodes receive from the mission's config (mission/mission_config.hpp explains each key).
// Metres, radians, millimetres, seconds. Pure values; the defaults are those of the competition.

#include "musher/modules/meilin/field/grid.hpp"

namespace musher::meilin {

struct Settings {
  Grid grid;
  Cell initial_cell{0, 0};
  double initial_height_mm = 0;
  double initial_yaw_rad = 0;
  double yaw_tolerance_rad = 0.12;
  double height_tolerance_mm = 1.0;
  double align_timeout_s = 30;       // not positive: no limit
  double suspension_timeout_s = 10;  // of the server; the nodes wait kServerMarginS longer
  double grasp_timeout_s = 30;
  double normal_height_mm = 30;  // of the wheels when the robot drives
  double pose_timeout_s = 1.0;   // not positive: a pose never grows old
};

// A server that has accepted a goal ends it within the limit that the goal has. One that does not
// is given so much longer; then the node fails.
inline constexpr double kServerMarginS = 5;

}  // namespace musher::meilin
