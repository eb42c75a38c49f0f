#include "musher/modules/navigation/controller_server/controller_config.hpp"

#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/navigation/gate/gate_toml.hpp"

namespace musher::navigation {
namespace {

using config_toml::TableReader;

ControllerRobot ReadControllerRobot(TableReader& reader, const std::vector<std::string>& names) {
  ControllerRobot robot;
  config::ReadRobot(reader, names, robot);
  robot.differential = reader.Choice<bool>("drive", {{"differential", true}, {"omni", false}})
                           .value_or(!robot.flies);
  if (robot.flies && robot.differential) {
    reader.Fault(reader.At("drive"), "drive", "a flyer is \"omni\"");
  }
  config::SetNumber(reader, "speed_m_s", 0.01, 20, robot.limits.speed_m_s);
  config::SetNumber(reader, "acceleration_m_s2", 0.01, 20, robot.limits.acceleration_m_s2);
  config::SetNumber(reader, "yaw_rad_s", 0.01, 20, robot.limits.yaw_rad_s);
  config::SetNumber(reader, "yaw_rad_s2", 0.01, 50, robot.limits.yaw_rad_s2);
  config::SetNumber(reader, "lag_s", 0, 2, robot.lag_s);
  config::SetNumber(reader, "arrive_m", 0.01, 5, robot.arrive_m);
  config::SetNumber(reader, "arrive_rad", 0.01, 3.15, robot.arrive_rad);
  config::SetNumber(reader, "join_m", 0.05, 100, robot.join_m);
  robot.gate.reaction_s += robot.lag_s;
  ReadGate(reader, robot.gate);
  robot.action = robot.name + "/follow_path";
  robot.trajectory = robot.name + "/timed_trajectory";
  robot.command = robot.name + "/cmd_vel";
  config::SetTopic(reader, "action", robot.action);
  config::SetTopic(reader, "trajectory", robot.trajectory);
  config::SetTopic(reader, "command", robot.command);
  robot.clear_memory = robot.name + "/clear_controller_memory";
  config::SetTopic(reader, "clear_memory", robot.clear_memory);
  robot.stamped = reader.Bool("command_stamped").value_or(robot.stamped);
  reader.RefuseOthers();
  return robot;
}

std::string ReadCheckerName(TableReader& reader) {
  reader.Require("name", "the id by which a goal asks for it");
  const auto name = reader.String("name");
  return name ? name->text : "";
}

void ReadCheckers(TableReader& root, ControllerConfig& config) {
  for (TableReader& reader : root.Subs("goal_checker")) {
    NamedGoalChecker checker{ReadCheckerName(reader)};
    config::SetNumber(reader, "arrive_m", 0.01, 5, checker.arrive_m);
    config::SetNumber(reader, "arrive_rad", 0.01, 3.15, checker.arrive_rad);
    reader.RefuseOthers();
    config.goal_checkers.push_back(std::move(checker));
  }
  for (TableReader& reader : root.Subs("progress_checker")) {
    NamedProgressChecker checker{ReadCheckerName(reader), {}};
    config::SetNumber(reader, "radius_m", 0.01, 100, checker.rules.radius_m);
    config::SetTime(reader, "time_ms", checker.rules.time);
    reader.RefuseOthers();
    config.progress_checkers.push_back(std::move(checker));
  }
}

ControllerConfig ReadController(const config_toml::Table& table, config_toml::Findings& findings) {
  ControllerConfig config;
  TableReader root(table, {1, 1}, "", findings);
  config::SetFrame(root, config.frame);
  config::SetTopic(root, "map", config.map, true);
  config::SetTopic(root, "cloud", config.cloud, true);
  config::SetTopic(root, "speed_limit", config.speed_limit, true);
  config::SetTopic(root, "keep_out", config.keep_out, true);
  config::SetTopic(root, "speed_mask", config.speed_mask, true);
  ReadCheckers(root, config);
  config::SetNumber(root, "cloud_resolution_m", 0.01, 10, config.cloud_resolution_m);
  config::SetTime(root, "odometry_stale_ms", config.odometry_stale);
  config::SetTime(root, "scan_stale_ms", config.scan_stale);
  config::SetTime(root, "obstacle_ms", config.obstacle_time);
  config::SetTime(root, "late_ms", config.late);
  config::SetTime(root, "self_check_ms", config.self_check_time);
  config::ReadMemory(root, config.memory);
  config::ReadTf(root, config.tf);
  config.robots = config::ReadRobots(root, findings, ReadControllerRobot);
  root.RefuseOthers();
  return config;
}

}  // namespace

Parsed<ControllerConfig> ReadControllerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<ControllerConfig>>(text, path, ReadController);
}

Parsed<ControllerConfig> ReadControllerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadControllerText);
}

}  // namespace musher::navigation
