#pragma once
// The paths of a body between the cells of a map: which cells belong together, and the shortest
// path from cell to cell (A* over 8 neighbours on the ground, 26 in the air). Complete: a path
// between cells is found if there is one, and that there is none is known without a search.
// Deterministic. Immutable once made; any thread.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "musher/navigation/planner/clearance.hpp"

namespace musher::navigation {

class CellSearch {
 public:
  // A body of this radius moves between the centres of neighbouring cells where it fits all along.
  // `stop`: called every thousand cells; true ends the computation.
  CellSearch(std::shared_ptr<const Clearance> clearance, double radius_m,
             const std::function<bool()>& stop = {});

  // False: it was stopped, and must not be used.
  bool complete() const { return complete_; }

  bool IsOpen(const Cell& cell) const { return map_.Has(cell) && region_[map_.IndexOf(cell)] != 0; }

  // The number of the region of an open cell, from 1 on; cells with the same one are connected.
  std::uint32_t RegionOf(const Cell& cell) const { return region_[map_.IndexOf(cell)]; }

  // In m², or m³ for a map of several layers.
  double SizeOf(std::uint32_t region) const;

  // The open cells around a place whose centre a body of `radius_m` can reach from there in a
  // straight line, the nearest first. `reach_m`: how far to look.
  std::vector<Cell> EntriesOf(const Point& place, double reach_m, double radius_m) const;

  struct Path {
    std::vector<Cell> cells;
    double length_m = 0;
  };

  // The shortest path between open cells of one region; none if `stop` returns true, which is
  // called every thousand cells.
  std::optional<Path> Search(const Cell& from, const Cell& to,
                             const std::function<bool()>& stop) const;

  // The shortest path to any cell whose index is `wanted`; none if there is none in the region.
  std::optional<Path> Nearest(const Cell& from, const std::function<bool(std::size_t)>& wanted,
                              const std::function<bool()>& stop) const;

 private:
  // `rest`: the least length from a cell to the end of the path.
  template <class IsEnd, class Rest>
  std::optional<Path> Expand(const Cell& from, IsEnd is_end, Rest rest,
                             const std::function<bool()>& stop) const;
  bool FindOpenCells(const std::function<bool()>& stop);
  bool LabelRegions(const std::function<bool()>& stop);
  bool Passes(std::size_t from, std::size_t to) const;

  std::shared_ptr<const Clearance> clearance_;
  const CellMap& map_;
  double radius_m_;
  std::vector<std::uint32_t> region_;  // 0: not open
  std::vector<bool> roomy_;            // the path to each neighbour that is roomy as well fits
  std::vector<std::size_t> sizes_;     // of each region, in cells
  bool complete_ = false;
};

}  // namespace musher::navigation
