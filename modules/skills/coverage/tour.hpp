#pragma once
// The order in which the cells of a region are covered, so that the paths between them are short.
// Metres. Pure; any thread.

#include <optional>
#include <vector>

#include "musher/modules/skills/coverage/cells.hpp"

namespace musher::coverage {

// The corners of a path through cells; to each but the first whether it is reached along a lane.
struct Tour {
  std::vector<GroundPoint> corners;
  std::vector<bool> on_lane;
  std::size_t cells = 0;           // that it covers
  std::size_t cells_left_out = 0;  // to which, or to a lane of which, no path keeps the radius
  std::vector<Edge> lanes_left_out;
};

// From `start`, if there is one, through the largest part of the cells that is joined. Exact for
// up to 8 cells; with more, always the nearest one comes next.
Tour TourOf(const std::vector<Cell>& cells, const std::optional<GroundPoint>& start,
            Router& router);

}  // namespace musher::coverage
