#pragma once
// Where the centre of a round robot may be in a region: at least its radius from each edge. Exact,
// without a raster. Metres in the frame of the map. Pure; one thread at a time.

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "musher/modules/skills/coverage/region.hpp"

namespace musher::coverage {

struct Interval {
  double begin_m = 0;
  double end_m = 0;
};

class FreeSpace {
 public:
  // A region that is Checked().
  FreeSpace(const Region& region, double radius_m);

  // The x of the free points with this y, in ascending order.
  std::vector<Interval> At(double y_m) const;
  // Whether the robot can go straight from a to b. `Passes` is the same for an `a` that is free.
  bool Clear(const GroundPoint& a, const GroundPoint& b) const;
  bool Passes(const GroundPoint& a, const GroundPoint& b) const;

  double radius_m() const { return radius_m_; }
  double lowest_m() const { return lowest_m_; }    // y of the region
  double highest_m() const { return highest_m_; }  // y of the region
  const std::vector<Edge>& edges() const { return edges_; }

 private:
  std::vector<Edge> edges_;
  double radius_m_ = 0;
  double lowest_m_ = 0;
  double highest_m_ = 0;
};

// The shortest paths in a free space: straight, or around corners of the region.
class Router {
 public:
  Router(const FreeSpace& space, const Region& region);

  // From a to b, both included; empty: there is none.
  std::vector<GroundPoint> Route(const GroundPoint& a, const GroundPoint& b);
  // To each of the points; infinite: there is no path.
  std::vector<double> Lengths(const GroundPoint& from, const std::vector<GroundPoint>& to);

 private:
  using Node = std::size_t;
  struct Tree {  // the shortest paths from a point to all nodes
    std::vector<double> length_m;
    std::vector<std::optional<Node>> before;
  };

  void AddNodes(const Ring& ring, bool hole);
  const std::vector<Node>& Visible(const GroundPoint& point);
  Tree From(const GroundPoint& point);
  // The last node of the shortest path over nodes, with its length.
  std::pair<std::optional<Node>, double> Last(const Tree& tree, const GroundPoint& to);

  const FreeSpace& space_;
  std::vector<GroundPoint> nodes_;
  std::vector<std::vector<Node>> neighbours_;
  std::map<std::pair<double, double>, std::vector<Node>> visible_;
};

}  // namespace musher::coverage
