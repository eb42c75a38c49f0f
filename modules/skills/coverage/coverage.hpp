#pragma once
// A path by which a round robot covers a region: parallel lanes over a polygon with holes
// (boustrophedon), with the paths between them.
//
//   region → cells without a hole → lanes in each → the order of the cells → one path
//
// The path keeps the robot's radius from the boundary and from the holes everywhere. Of all
// directions of edges, the lanes have the one with the fewest turns.
//
// Metres and radians in the frame of the map. Pure; any thread. A hall with 10 holes takes 20
// milliseconds, one with 30 a third of a second; the limits below keep all requests near that.

#include <optional>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/skills/coverage/region.hpp"

namespace musher::coverage {

struct Options {
  double lane_width_m = 2;  // from lane to lane at most; the width that a lane covers
  double robot_radius_m = 0.5;
};

struct Plan {
  std::vector<GroundPoint> corners;  // straight lines between
  std::vector<bool> on_lane;         // of each of these lines
  std::size_t lanes = 0;
  double length_m = 0;
  double between_m = 0;      // of it between lanes
  double direction_rad = 0;  // of the lanes
  std::size_t cells = 0;
  std::size_t cells_left_out = 0;  // that the robot cannot reach, or not all of their lanes
  std::vector<Edge> lanes_left_out;
};

inline constexpr std::size_t kMostCells = 60;
inline constexpr std::size_t kMostLanes = 2000;

// `start`: where the robot is. Fails for a region that is none (see Checked()), a width that is not
// above 0 or a radius below 0, a robot that does not fit into the region, and for more than
// kMostCells or kMostLanes.
Result<Plan> PlanCoverage(const Region& region, const Options& options,
                          const std::optional<GroundPoint>& start);

// Points along the corners, at most `distance_m` apart; `distance_m` is above 0.
std::vector<GroundPoint> Interpolated(const std::vector<GroundPoint>& corners, double distance_m);

}  // namespace musher::coverage
