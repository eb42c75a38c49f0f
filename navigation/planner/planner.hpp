#pragma once
// Finds a path for a round body over a map, on the ground or in the air.
//
//   1. Cells with room for the body form regions, computed once for a map. A start or goal in an
//      obstacle, outside the map or in another region is refused at once, without a search.
//   2. The shortest path from cell to cell (A*), with `comfort_m` more room if the detour is
//      small.
//   3. OMPL's shortcuts and B-splines make it short and smooth; the body fits everywhere.
//
// Complete to the resolution of the map: a passage is found if it is wider than the body by a cell.
// No search by samples: it is not faster for paths of the same length, and cannot say that there is
// none (docs/decisions/30-search-by-cells.md). Metres, radians, the frame of the map. Immutable
// once made; any thread. Errors have a code of Fault.

#include <functional>
#include <memory>
#include <string>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/planner/cell_search.hpp"
#include "musher/navigation/planner/headings.hpp"
#include "musher/navigation/planner/smoothing.hpp"

namespace musher::navigation {

struct PlannerRules {
  double radius_m = 0.3;        // of the body, with what its control needs
  double comfort_m = 0.1;       // more room than that, where it is cheap
  double detour = 1.25;         // the longest comfortable path, by the shortest one
  double start_within_m = 0.1;  // a body that stands so much too close to a wall may leave
  Heading heading = Heading::kAlong;
  SmoothingRules smoothing;
};

struct Plan {
  Path path;
  double length_m = 0;       // of the path
  double cell_length_m = 0;  // of the shortest path from cell to cell
};

class Planner {
 public:
  // `stop`: asked now and then; true ends the computation with Fault::kTimeLimit.
  static Result<Planner> Make(CellMap map, const PlannerRules& rules,
                              const std::function<bool()>& stop = {});

  // `stop`: asked now and then during the search; true ends it with Fault::kTimeLimit.
  Result<Plan> Find(const Pose& start, const Pose& goal,
                    const std::function<bool()>& stop = {}) const;

  // The same to the nearest place whose cell is `wanted`; it looks there in the direction in which
  // it comes.
  Result<Plan> FindNearest(const Pose& start, const std::function<bool(std::size_t cell)>& wanted,
                           const std::function<bool()>& stop = {}) const;

  const Clearance& clearance() const { return *clearance_; }

 private:
  struct Ends;

  Planner(CellMap map, const PlannerRules& rules, const std::function<bool()>& stop);
  bool complete() const;  // the computation was not stopped
  Result<> CheckEnd(const std::string& name, const Pose& pose, double radius_m,
                    Fault blocked) const;
  Result<> CheckStart(const Pose& start) const;
  Result<Ends> Connect(const Point& start, const Point& goal) const;
  std::vector<Point> Shortened(const std::vector<Cell>& cells, const Point& start,
                               const Point& goal, double radius_m) const;

  PlannerRules rules_;
  std::shared_ptr<const Clearance> clearance_;
  std::shared_ptr<const CellSearch> search_;
  std::shared_ptr<const CellSearch> comfortable_;
};

}  // namespace musher::navigation
