#pragma once
// The lane's line beside the body, through points on the ground. Pure; deterministic; robust
// against points of other lines. Frame and units of ground.hpp; angles in radians, to the left
// positive. Any thread.

#include <array>
#include <optional>

#include "musher/modules/line_walker/ground.hpp"

namespace musher::line_walker {

enum class Side { kLeft, kRight };

struct FitRules {
  double tolerance_m = 0.03;           // a point farther from a curve is none of it
  double nearest_m = 0.05;             // a line beside the body is at least so far from its middle
  double farthest_m = 1.0;             // and at most so far
  double back_m = 0.5;                 // points from so far behind the body's middle
  double ahead_m = 0.9;                // to so far ahead are used
  int least_points = 8;                // of a line
  double least_span_m = 0.25;          // of a line, along the body
  double tightest_m = 0.8;             // radius; a tighter arc is none of a lane
  double steepest_rad = kDegree * 57;  // between the line and the body

  friend bool operator==(const FitRules&, const FitRules&) = default;
};

// A line beside the body, at the point of it that is nearest to the body's middle.
struct SideLine {
  double distance_m = 0;   // to that point; positive on both sides
  double heading_rad = 0;  // of the line there, from the body's x
  double curvature_per_m = 0;
  double quality = 0;             // from 0 to 1
  std::array<double, 3> curve{};  // y = c0 + c1 x + c2 x^2
  double far_x_m = 0;             // of its farthest point ahead
};

// The nearest line of that side: y = c0 + c1 x + c2 x^2. A line twice as dense does not outvote a
// nearer one. `curvature_per_m`: what is assumed where the points cover too little to show it.
std::optional<SideLine> FitSideLine(const GroundPoints& points, Side side, const FitRules& rules,
                                    double curvature_per_m = 0);

}  // namespace musher::line_walker
