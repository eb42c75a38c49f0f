#pragma once
// A map in space as an octree (OctoMap): from point clouds, whose rays also show what is free, or
// from a file. The planner takes it as cells. Metres, the frame of the map. One thread at a time.

#include <memory>
#include <string>
#include <vector>

#include "musher/navigation/planner/cell_map.hpp"

namespace musher::navigation {

class OctreeMap {
 public:
  // Leaves of this size. Fails unless it is between 1 mm and 100 m.
  static Result<OctreeMap> Make(double resolution_m);

  // The content of a file of OctoMap, binary (.bt) or full (.ot).
  static Result<OctreeMap> Read(const std::string& content);

  OctreeMap(OctreeMap&&) noexcept;
  OctreeMap& operator=(OctreeMap&&) noexcept;
  ~OctreeMap();

  // The places of points are blocked. Points that are not finite, or farther than the tree reaches
  // (32768 leaves either way), are left out; returns how many were used.
  std::size_t Block(const std::vector<Point>& points);

  // What a sensor at `from` has seen: each ray is free up to its point, or up to `range_m`, and the
  // points within the range are blocked.
  std::size_t See(const Point& from, const std::vector<Point>& points, double range_m);

  // The content of a file .bt.
  std::string Binary() const;

  double resolution_m() const;

  struct CellRules {
    bool unknown_is_free = true;
    double margin_m = 1.0;  // of cells around what is known
  };

  // All that is known, as cells of the size of a leaf. Fails if nothing is, or for too many cells.
  Result<CellMap> Cells(const CellRules& rules) const;

 private:
  struct Tree;

  explicit OctreeMap(std::unique_ptr<Tree> tree);

  std::unique_ptr<Tree> tree_;
};

}  // namespace musher::navigation
