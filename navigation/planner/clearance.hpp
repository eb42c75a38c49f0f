#pragma once
// How far every place of a map is from what blocks it. The distances between the centres of cells
// are computed once for a map, exactly (squared distances by lower envelopes of parabolas, one axis
// after the other); a place where they leave a doubt is compared with the blocked cells around it.
// Metres. Immutable once made; any thread.

#include <functional>
#include <limits>
#include <vector>

#include "musher/navigation/planner/cell_map.hpp"

namespace musher::navigation {

class Clearance {
 public:
  // The map must have passed CheckCellMap(). `stop`: called for each row of cells; true ends the
  // computation.
  explicit Clearance(CellMap map, const std::function<bool()>& stop = {});

  // False: it was stopped, and must not be used.
  bool complete() const { return complete_; }

  const CellMap& map() const { return map_; }

  // Distance from a cell's centre to that of the nearest blocked cell; infinite if none is.
  double OfCell(std::size_t index) const { return distance_m_[index]; }

  // A disc (a ball) with this radius around `centre` touches no blocked cell, and its centre is on
  // the map. Exact.
  bool Fits(const Point& centre, double radius_m) const;

  // The same for the whole line between two places, looked at every fifth of a cell where it is
  // near a blocked one: a corner may reach in by a hundredth of a cell (a tenth for radius 0).
  bool FitsAlong(const Point& from, const Point& to, double radius_m) const;

  // Distance from a place to the nearest blocked cell, at most `limit_m`. Exact.
  double At(const Point& place, double limit_m) const;

 private:
  double ToNearestCell(const Point& in_cells, double limit_cells) const;
  void ComputeDistances(const std::function<bool()>& stop);

  CellMap map_;
  std::vector<float> distance_m_;
  bool complete_ = false;
};

// The points that the map does not explain: those farther than `within_m` from its blocked cells.
std::vector<Point> NewPoints(const std::vector<Point>& points, const Clearance& clearance,
                             double within_m);

}  // namespace musher::navigation
