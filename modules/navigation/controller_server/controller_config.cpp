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
  if (robot.flies) robot.gate.blind_m_s = kFlyerBlindMS;
  ReadGate(reader, robot.gate);
  robot.action = robot.name + "/follow_path";
  robot.trajectory = robot.name + "/timed_trajectory";
  robot.command = robot.name + "/cmd_vel";
  config::SetTopic(reader, "action", robot.action);
  config::SetTopic(reader, "trajectory", robot.trajectory);
  config::SetTopic(reader, "command", robot.command);
  robot.stamped = reader.Bool("command_stamped").value_or(robot.stamped);
  reader.RefuseOthers();
  return robot;
}

ControllerConfig ReadController(const config_toml::Table& table, config_toml::Findings& findings) {
  ControllerConfig config;
  TableReader root(table, {1, 1}, "", findings);
  config::SetFrame(root, config.frame);
  config::SetTopic(root, "map", config.map, true);
  config::SetTopic(root, "cloud", config.cloud, true);
  config::SetTopic(root, "speed_limit", config.speed_limit, true);
  config::SetNumber(root, "cloud_resolution_m", 0.01, 10, config.cloud_resolution_m);
  config::SetTime(root, "odometry_stale_ms", config.odometry_stale);
  config::SetTime(root, "scan_stale_ms", config.scan_stale);
  config::SetTime(root, "obstacle_ms", config.obstacle_time);
  config::SetTime(root, "late_ms", config.late);
  config::SetTime(root, "self_check_ms", config.self_check_time);
  config.robots = config::ReadRobots(root, findings, ReadControllerRobot);
  root.RefuseOthers();
  return config;
}

}  // namespace

ControllerReading ReadControllerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<ControllerReading>(text, path, ReadController);
}

ControllerReading ReadControllerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadControllerText);
}

}  // namespace musher::navigation
