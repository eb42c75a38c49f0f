#include "musher/modules/navigation/route_server/route_config.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::TableReader;

constexpr std::string_view kTopicExample = "jetbot_0/odom";

RouteRobot ReadRouteRobot(TableReader& reader, const std::vector<std::string>& names) {
  RouteRobot robot;
  config::ReadName(reader, names, robot.name);
  robot.odometry = robot.name + "/odom";
  robot.action = robot.name + "/compute_route";
  robot.track = robot.name + "/compute_and_track_route";
  config_toml::ReadRows(reader, {row::Topic("odometry", robot.odometry, kTopicExample),
                                 row::Topic("action", robot.action, kTopicExample),
                                 row::Topic("track", robot.track, kTopicExample)});
  return robot;
}

RouteConfig ReadRoute(const config_toml::Table& table, Findings& findings,
                      const std::filesystem::path& folder) {
  RouteConfig config;
  TableReader root(table, {1, 1}, "", findings);
  config::SetFrame(root, config.frame);
  config::ReadTf(root, config.tf);
  config.robots = config::ReadRobots(root, findings, ReadRouteRobot);
  config_toml::ReadRows(
      root,
      {row::Required("graph", "the GeoJSON file of the graph, as in \"route_graph.geojson\"",
                     row::File("graph", config.graph_file, folder)),
       row::Topic("edges", config.edges, kTopicExample),
       row::Topic("set_graph", config.set_graph, kTopicExample),
       row::Number("step_m", config.step_m, 0.01, 10), row::Number("near_m", config.near_m, 0, 1e6),
       row::Number("beside_m", config.beside_m, 0, 100),
       row::Number("reached_m", config.track.reached_m, 0.05, 100),
       row::Number("end_reached_m", config.track.end_reached_m, 0.05, 100),
       row::Time("stale_ms", config.stale), row::Time("self_check_ms", config.self_check_time)});
  return config;
}

}  // namespace

Result<RouteGraph> ReadGraphFile(const std::string& path, const std::string& frame) {
  // A pipe, also one that a request names, would never end.
  std::error_code error;
  const bool exists = std::filesystem::exists(path, error);
  if (exists && !std::filesystem::is_regular_file(path, error)) {
    return MakeError(Fault::kMap, path + ": it is no regular file");
  }
  const auto text = config_toml::ReadTextFile(path, kMostGraphBytes);
  if (!text) return MakeError(Fault::kMap, path + ": " + text.error().message);
  auto graph = ReadRouteGraph(text.value(), frame);
  if (!graph) return MakeError(Fault::kMap, path + ": " + graph.error().message);
  return graph;
}

Parsed<RouteConfig> ReadRouteText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<RouteConfig>>(
      text, path, [&path](const config_toml::Table& table, Findings& findings) {
        return ReadRoute(table, findings, std::filesystem::path(path).parent_path());
      });
}

Parsed<RouteConfig> ReadRouteFile(const std::string& path) {
  Parsed<RouteConfig> reading = config_toml::ReadFileWith(path, ReadRouteText);
  if (!reading.config) return reading;
  RouteConfig& config = *reading.config;
  auto graph = ReadGraphFile(config.graph_file, config.frame);
  if (graph) {
    config.graph = std::make_shared<const RouteGraph>(std::move(graph).value());
  } else {
    reading.diagnostics.push_back(
        {path, 0, 0, Severity::kError, "graph: " + graph.error().message});
    reading.config.reset();
  }
  return reading;
}

}  // namespace musher::navigation
