#pragma once
// The file of musher-route; config/navigation/route.toml explains its keys.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/navigation/server/robot_table.hpp"
#include "musher/navigation/route/route_graph.hpp"
#include "musher/navigation/route/route_tracker.hpp"

namespace musher::navigation {

struct RouteRobot {
  std::string name;
  std::string odometry;  // <name>/odom
  std::string action;    // <name>/compute_route
  std::string track;     // <name>/compute_and_track_route
};

struct RouteConfig {
  std::string frame = "map";
  std::string graph_file;                   // GeoJSON
  std::shared_ptr<const RouteGraph> graph;  // of it; null: no file was read
  std::string edges = "route_server/DynamicEdgesScorer/adjust_edges";  // nav2_msgs/DynamicEdges
  std::string set_graph = "route_server/set_route_graph";              // nav2_msgs/SetRouteGraph
  double step_m = 0.05;                // between the poses of a path, at most
  double near_m = 10;                  // from a pose to the nearest node, at most
  double beside_m = 1;                 // of an edge whose begin or end is left out
  TrackRules track;                    // when a node is reached
  Duration stale = Milliseconds(500);  // older odometry is not used
  Duration self_check_time = Milliseconds(5000);
  TfSource tf;
  std::vector<RouteRobot> robots;
};

// Never throws; a file that is unreadable, and a graph that cannot be used, are diagnostics.
Parsed<RouteConfig> ReadRouteFile(const std::string& path);

// The same for a text, without the graph; `path` is what diagnostics refer to.
Parsed<RouteConfig> ReadRouteText(std::string_view text, const std::string& path);

// The graph of a file; the message of the Error begins with its name.
Result<RouteGraph> ReadGraphFile(const std::string& path, const std::string& frame);

}  // namespace musher::navigation
