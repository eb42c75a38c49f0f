#pragma once
// A graph of places for long ways, as nav2's route server has it: nodes with an id, and edges in
// one direction from node to node. It is read from GeoJSON:
//
//   a feature Point: a node         properties: id, frame
//   a feature MultiLineString       properties: id, startid, endid, cost, overridable
//   or LineString: an edge
//
// An edge is straight; its own coordinates are not read. It costs its length, unless it has
// `overridable` false: then its `cost`. Other properties are left out.
//
// Metres, the frame of the map. Plain values; any thread.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

using RouteId = std::uint16_t;  // as the messages have it: a graph has 65,536 of each kind at most

struct GraphNode {
  RouteId id = 0;
  Point at;
};

struct GraphEdge {
  RouteId id = 0;
  std::size_t from = 0;  // index of a node
  std::size_t to = 0;
  double cost = 0;
};

struct RouteGraph {
  std::vector<GraphNode> nodes;                 // by id
  std::vector<GraphEdge> edges;                 // by id
  std::vector<std::vector<std::size_t>> leave;  // of each node: its edges, by id

  std::optional<std::size_t> NodeOf(RouteId id) const;  // its index
  std::optional<std::size_t> EdgeOf(RouteId id) const;
};

inline constexpr std::size_t kMostGraphBytes = std::size_t{64} << 20U;
inline constexpr double kFarthestNodeM = 1e6;  // from the origin, along each axis

// Nodes whose `frame` is another one than `frame` are refused; none counts as it. Fails with
// Fault::kMap, with the place of the first fault and the number of all: "line 3, column 7: …",
// "features[12].properties.startid: …".
Result<RouteGraph> ReadRouteGraph(std::string_view geojson, const std::string& frame);

// What a program has said of edges since the graph was read.
struct EdgeChanges {
  std::set<std::size_t> closed;          // indices of edges
  std::map<std::size_t, double> dearer;  // what they cost more; from 0
};

double CostOf(const RouteGraph& graph, std::size_t edge, const EdgeChanges& changes);

// A way through the graph, in the order of the motion.
struct Route {
  std::vector<std::size_t> nodes;  // indices; not empty
  std::vector<std::size_t> edges;  // from each node to the next one
  double cost = 0;                 // the sum of its edges

  friend bool operator==(const Route&, const Route&) = default;
};

// The cheapest one; of several that cost the same, the same each time. One node where both are the
// same. Fails with Fault::kWalledIn.
Result<Route> FindRoute(const RouteGraph& graph, std::size_t from, std::size_t to,
                        const EdgeChanges& changes = {});

// The nearest node within `within_m`, of several as near the one with the smallest id. Heights do
// not count. Fails with Fault::kOutside; `what` is "the goal".
Result<std::size_t> NearestNode(const RouteGraph& graph, const Point& place, double within_m,
                                const std::string& what);

// Leaves out the first node where `start` is beside the first edge, and the last one where `goal`
// is beside the last edge: both within `within_m` of it, and at least 0.1 m past its begin or
// before its end. One node stays. Nullopt: nothing is left out at that end.
Route WithoutDetours(const RouteGraph& graph, Route route, const std::optional<Point>& start,
                     const std::optional<Point>& goal, double within_m,
                     const EdgeChanges& changes = {});

// A pose at least each `step_m`, at most 100,000, that look along the route. Where it is one node
// they look along `yaw_rad`.
Path PathAlong(const RouteGraph& graph, const Route& route, double step_m, double yaw_rad = 0);

}  // namespace musher::navigation
