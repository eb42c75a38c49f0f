#pragma once
// The line across the lane's end, seen ahead. Pure; deterministic. Frame and units of ground.hpp;
// angles in radians, to the left positive. Any thread.
//
// A line of the lane's side also crosses the picture where the lane curves. It is told from an end
// line by its direction alone: an arc with an outer radius of 2 m turns by 37 degrees within the
// 1.2 m that are looked at.

#include <optional>

#include "musher/modules/line_walker/ground.hpp"

namespace musher::line_walker {

struct EndRules {
  double within_m = 1.2;             // from the body's middle; a line farther away is not looked at
  double tolerance_m = 0.03;         // a point farther from a line is none of it
  double least_span_m = 0.35;        // across the lane
  double longest_gap_m = 0.1;        // between points of one line
  double squint_rad = kDegree * 34;  // from the perpendicular to the lane
  int least_points = 8;
};

struct EndLine {
  GroundPoint middle;
  double heading_rad = 0;  // of a lane that ends perpendicularly there, from the body's x
};

// The nearest such line of the points. `lane_heading_rad`: of the lane beside the body, from its x.
std::optional<EndLine> FindEndLine(const GroundPoints& points, double lane_heading_rad,
                                   const EndRules& rules);

}  // namespace musher::line_walker
