#include "musher/navigation/masks/filter_mask.hpp"

#include <cmath>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

// A map with the places of the cells of a grid, without cells.
CellMap FrameOf(const OccupancyGrid& grid) {
  CellMap map;
  map.resolution_m = grid.resolution_m;
  map.origin = grid.origin;
  map.size_x = static_cast<int>(grid.width);
  map.size_y = static_cast<int>(grid.height);
  return map;
}

// In all layers.
void Block(CellMap& map, const Cell& cell) {
  for (int z = 0; z < map.size_z; ++z) {
    const Cell at{cell.x, cell.y, z};
    if (map.Has(at)) map.blocked[map.IndexOf(at)] = 1;
  }
}

}  // namespace

std::optional<double> FilterMask::At(const Point& place) const {
  if (!IsFinite(place)) return std::nullopt;
  const CellMap frame = FrameOf(grid);
  const Cell cell = frame.CellOf(place);
  if (!frame.Has({cell.x, cell.y, 0})) return std::nullopt;
  const std::int8_t occupancy = grid.data[frame.IndexOf({cell.x, cell.y, 0})];
  if (occupancy < 0) return std::nullopt;
  return base + multiplier * occupancy;
}

Result<> CheckFilterMask(const FilterMask& mask) {
  if (!std::isfinite(mask.base) || !std::isfinite(mask.multiplier)) {
    return MakeError(Fault::kMap, "mask: its base or multiplier is not finite");
  }
  const auto cells = FromOccupancyGrid(mask.grid, {});
  return cells ? Ok() : Result<>(cells.error());
}

CellMap KeepOutCells(const FilterMask& mask, int blocked_from) {
  CellMap map = FrameOf(mask.grid);
  for (const std::int8_t occupancy : mask.grid.data) {
    map.blocked.push_back(occupancy >= 0 &&
                          mask.base + mask.multiplier * occupancy >= blocked_from);
  }
  return map;
}

void BlockKeepOut(const CellMap& keep_out, CellMap& map) {
  // Each way round: either one may have the finer cells.
  for (std::size_t i = 0; i < keep_out.count(); ++i) {
    if (keep_out.blocked[i]) Block(map, map.CellOf(keep_out.CentreOf(keep_out.CellAt(i))));
  }
  for (int y = 0; y < map.size_y; ++y) {
    for (int x = 0; x < map.size_x; ++x) {
      const Cell cell = keep_out.CellOf(map.CentreOf({x, y, 0}));
      if (keep_out.Has(cell) && keep_out.blocked[keep_out.IndexOf(cell)]) Block(map, {x, y, 0});
    }
  }
}

}  // namespace musher::navigation
