#pragma once
// Graphs of routes for tests, as GeoJSON and as what is read of it.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "musher/navigation/route/route_graph.hpp"

namespace musher::navigation::testing {

// `more` of the properties: `"frame": "map"`.
inline std::string NodeJson(int id, const std::string& coordinates, const std::string& more = "") {
  return fmt::format(
      R"({{"type": "Feature", "geometry": {{"type": "Point", "coordinates": {}}}, "properties": {{"id": {}{}{}}}}})",
      coordinates, id, more.empty() ? "" : ", ", more);
}
inline std::string EdgeJson(int id, int from, int to, const std::string& more = "") {
  return fmt::format(
      R"({{"type": "Feature", "geometry": {{"type": "MultiLineString"}}, "properties": {{"id": {}, "startid": {}, "endid": {}{}{}}}}})",
      id, from, to, more.empty() ? "" : ", ", more);
}
// `before` the features: `"name": "graph", `.
inline std::string GraphJson(const std::vector<std::string>& features,
                             const std::string& before = "") {
  return fmt::format("{{{}\"type\": \"FeatureCollection\", \"features\": [{}]}}", before,
                     fmt::join(features, ",\n"));
}

struct NodeAt {
  RouteId id;
  Point at;
};
struct EdgeBetween {
  RouteId id, from, to;
};

inline std::string JsonOf(const std::vector<NodeAt>& nodes, const std::vector<EdgeBetween>& edges) {
  std::vector<std::string> features;
  for (const NodeAt& node : nodes) {
    features.push_back(
        NodeJson(node.id, fmt::format("[{}, {}, {}]", node.at.x_m, node.at.y_m, node.at.z_m)));
  }
  for (const EdgeBetween& edge : edges) features.push_back(EdgeJson(edge.id, edge.from, edge.to));
  return GraphJson(features);
}
inline RouteGraph GraphOf(const std::vector<NodeAt>& nodes, const std::vector<EdgeBetween>& edges) {
  auto graph = ReadRouteGraph(JsonOf(nodes, edges), "map");
  if (!graph) ADD_FAILURE() << graph.error().message;
  return std::move(graph).value();
}

}  // namespace musher::navigation::testing
