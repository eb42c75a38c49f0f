#pragma once
// How far a robot is along a route. It only watches: what moves the robot is not its concern.
//
//   before the first node ─→ between two nodes ─→ … ─→ at the last node (done)
//
// The first and the last node are reached within a radius. One between is reached where the robot
// is near it and has passed the line that halves the corner there. The first one and those between
// are reached also where the robot is beside the edge that leaves them, and not beside the one that
// leads there. Heights do not count.
//
// Pure; one thread.

#include <memory>
#include <optional>

#include "musher/navigation/route/route_graph.hpp"

namespace musher::navigation {

struct TrackRules {
  double reached_m = 2;      // of a node between
  double end_reached_m = 1;  // of the first and the last one
};

class RouteTracker {
 public:
  // `reached`: how many nodes of the route it has reached already.
  RouteTracker(std::shared_ptr<const RouteGraph> graph, Route route, const TrackRules& rules,
               std::size_t reached = 0);

  // True: it has reached another node, or several.
  bool Update(const Point& at);
  bool done() const { return next_ == route_.nodes.size(); }

  // Indices of the graph. Nullopt: there is none.
  std::optional<std::size_t> last_node() const;
  std::optional<std::size_t> next_node() const;
  std::optional<std::size_t> edge() const;  // between the two
  const Route& route() const { return route_; }
  const RouteGraph& graph() const { return *graph_; }

  // Whether an edge of what is left of the route is closed: that of now, or a later one.
  bool IsClosed(const EdgeChanges& changes) const;

 private:
  bool IsReached(const Point& at) const;

  std::shared_ptr<const RouteGraph> graph_;
  Route route_;
  TrackRules rules_;
  std::size_t next_;  // of the nodes of the route
};

}  // namespace musher::navigation
