#pragma once
// The line across the lane's end, seen ahead. Pure; deterministic. Frame and units of ground.hpp;
// angles in radians, to the left positive. Any thread.
//
// Where a lane is open at its end, the ends of its two lines show it: see FindSideEnd().
//
// A line of the lane's side also crosses the picture where the lane curves. It differs from an end
// line by its direction alone: an arc with an outer radius of 2 m turns by 37 degrees within the
// 1.2 m that are looked at.

#include <optional>

#include "musher/modules/line_walker/ground.hpp"
#include "musher/modules/line_walker/line_fit.hpp"

namespace musher::line_walker {

struct EndRules {
  double within_m = 1.2;             // from the body's middle; a line farther away is not looked at
  double tolerance_m = 0.03;         // a point farther from a line is none of it
  double least_span_m = 0.35;        // across the lane
  double longest_gap_m = 0.1;        // between points of one line
  double squint_rad = kDegree * 34;  // from the perpendicular to the lane
  int least_points = 8;
  double side_within_m = 0.65;  // the end of a line beside the body is looked for so far ahead
  double side_gap_m = 0.25;     // beyond an end nothing of the line is seen for so long

  friend bool operator==(const EndRules&, const EndRules&) = default;
};

struct EndLine {
  GroundPoint middle;
  double heading_rad = 0;  // of a lane that ends perpendicularly there, from the body's x
};

// The nearest such line of the points. `lane_heading_rad`: of the lane beside the body, from its x.
std::optional<EndLine> FindEndLine(const GroundPoints& points, double lane_heading_rad,
                                   const EndRules& rules);

// The end of a line beside the body, if it ends ahead: its edge stops where the camera would show
// more of it. `points`: the whole edge on the ground. `middle` is beside it, in the lane's middle.
std::optional<EndLine> FindSideEnd(const GroundPoints& points, const SideLine& line, Side side,
                                   const MountedCamera& camera, double trunk_height_m,
                                   double lane_width_m, const EndRules& rules);

}  // namespace musher::line_walker
