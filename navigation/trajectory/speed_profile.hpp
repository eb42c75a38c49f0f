#pragma once
// How fast a body can go along a curve within its limits: the fastest progress, by the reachability
// analysis of time-optimal path parameterisation. Backwards, for every point of a fine grid, the
// highest speed from which the rest can be driven; forwards, the strongest permitted acceleration.
//
// With progress speed w and x = w², velocity is slope * w, acceleration is slope * a + bend * x. In
// an interval `a` is constant, so x and the slope are linear in u, and the limits hold in between
// as they hold at its ends. Pure; any thread.

#include <vector>

#include "musher/navigation/trajectory/path_curve.hpp"

namespace musher::navigation {

// Limits of the speed in space and of the turn about the vertical.
struct MotionLimits {
  double speed_m_s = 1.5;
  double acceleration_m_s2 = 0.8;
  double yaw_rad_s = 1.0;
  double yaw_rad_s2 = 1.5;
};

// A part of the grid, within one piece of the curve.
struct Interval {
  std::size_t piece = 0;
  double from = 0;  // s in the piece
  double length = 0;
  double x = 0;             // squared progress speed at its begin
  double acceleration = 0;  // of the progress
  double seconds = 0;
};

// `start_speed_m_s`: of the body at the begin, used as far as the curve permits it; at its end it
// stands. `pieces` is a curve of MakeCurve().
std::vector<Interval> FastestProgress(const std::vector<CurvePiece>& pieces,
                                      const MotionLimits& limits, double start_speed_m_s);

}  // namespace musher::navigation
