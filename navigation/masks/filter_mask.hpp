#pragma once
// A mask over the map, as those of nav2's costmap filters: where no path may lead, or how fast a
// robot may be. It is an occupancy grid of any resolution; unknown cells and places beside it have
// no value. Metres, the frame of the map. Plain value; any thread.

#include <optional>

#include "musher/navigation/planner/cell_map.hpp"

namespace musher::navigation {

struct FilterMask {
  OccupancyGrid grid;
  double base = 0;
  double multiplier = 1;

  // base + multiplier * occupancy. Nullopt: unknown, or beside the mask.
  std::optional<double> At(const Point& place) const;
};

// Fails for a grid without cells, of a size that does not fit, and for numbers that are not finite.
Result<> CheckFilterMask(const FilterMask& mask);

// The cells of the mask with `blocked_from` per cent or more as blocked cells, on their own.
CellMap KeepOutCells(const FilterMask& mask, int blocked_from);

// Blocks them in a map, in all of its layers.
void BlockKeepOut(const CellMap& keep_out, CellMap& map);

}  // namespace musher::navigation
