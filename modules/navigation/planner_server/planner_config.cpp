#include "musher/modules/navigation/planner_server/planner_config.hpp"

#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"

namespace musher::navigation {
namespace {

using config_toml::Findings;
using config_toml::TableReader;

PlannerRobot ReadPlannerRobot(TableReader& reader, const std::vector<std::string>& names) {
  PlannerRobot robot;
  config::ReadRobot(reader, names, robot);
  config::SetNumber(reader, "comfort_m", 0, 10, robot.comfort_m);
  robot.action = robot.name + "/compute_path_to_pose";
  robot.path = robot.name + "/planned_path";
  robot.refuge = robot.name + "/compute_refuge";
  config::SetTopic(reader, "action", robot.action);
  config::SetTopic(reader, "path", robot.path);
  config::SetTopic(reader, "refuge", robot.refuge);
  robot.clear_memory = robot.name + "/clear_planner_memory";
  config::SetTopic(reader, "clear_memory", robot.clear_memory);
  reader.RefuseOthers();
  return robot;
}

PlannerConfig ReadPlanner(const config_toml::Table& table, Findings& findings) {
  PlannerConfig config;
  TableReader root(table, {1, 1}, "", findings);
  config::SetFrame(root, config.frame);
  config::SetTopic(root, "map", config.map);
  config::SetTopic(root, "cloud", config.cloud);
  config::SetTopic(root, "keep_out", config.keep_out, true);
  config::SetTime(root, "limit_ms", config.limit);
  config::SetTime(root, "stale_ms", config.stale);
  config::SetTime(root, "self_check_ms", config.self_check_time);
  if (const auto blocked = root.Integer("blocked_from", 1, 100, "%")) {
    config.blocked_from = static_cast<int>(*blocked);
  }
  config.unknown_is_free = root.Bool("unknown_is_free").value_or(config.unknown_is_free);
  config::SetNumber(root, "cloud_resolution_m", 0.01, 10, config.cloud_resolution_m);
  config::SetNumber(root, "cloud_margin_m", 0, 100, config.cloud_margin_m);
  config::SetNumber(root, "ceiling_m", 0.1, 1000, config.ceiling_m);
  config::ReadMemory(root, config.memory);
  config::ReadTf(root, config.tf);
  config.robots = config::ReadRobots(root, findings, ReadPlannerRobot);
  root.RefuseOthers();
  return config;
}

}  // namespace

Parsed<PlannerConfig> ReadPlannerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<PlannerConfig>>(text, path, ReadPlanner);
}

Parsed<PlannerConfig> ReadPlannerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadPlannerText);
}

}  // namespace musher::navigation
