#pragma once
// Divides a free space into cells that parallel lanes cover without an interruption (boustrophedon
// decomposition): each ends where the free interval of the line splits, joins another one or
// becomes wider or narrower at a corner. The lanes are parallel to the x axis. Metres. Pure; any
// thread.

#include <vector>

#include "musher/modules/skills/coverage/free_space.hpp"

namespace musher::coverage {

struct Lane {
  double y_m = 0;
  Interval x;
};

struct Cell {
  std::vector<Lane> lanes;  // from the lowest one up; at least one
};

// Lanes are at most `lane_width_m` apart, and at most half of that from walls, where the robot's
// radius lets them. `slice_m`: the height at which the space is sampled; what is flatter may be
// missed. `whole`: with more lanes in cells of few lanes, for what those leave of their ends.
std::vector<Cell> CellsOf(const FreeSpace& space, double lane_width_m, double slice_m, bool whole);

}  // namespace musher::coverage
