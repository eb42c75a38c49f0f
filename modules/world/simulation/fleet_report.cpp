#include "musher/modules/world/simulation/fleet_report.hpp"

#include <cstdio>

namespace musher::world {
namespace {

std::string NameOfHeld(const World& world, const FleetRobot& robot) {
  return robot.holds ? world.scene().objects[*robot.holds].name : "";
}

std::string JsonName(const std::string& text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') quoted += '\\';
    if (static_cast<unsigned char>(letter) >= 0x20) quoted += letter;
  }
  return quoted + '"';
}

}  // namespace

std::string FleetText(const World& world) {
  if (world.fleet().robots().empty()) return "the scene has no [[robot]]";
  char line[256];
  std::snprintf(line, sizeof(line), "%-14s %8s %8s %8s %8s %9s %8s %11s  %s", "robot", "x, m",
                "y, m", "z, m", "yaw, deg", "battery", "driven", "collisions", "holds");
  std::string text = line;
  for (std::size_t i = 0; i < world.fleet().robots().size(); ++i) {
    const FleetRobot& robot = world.fleet().robots()[i];
    const Eigen::Vector3d& at = robot.body.position_m();
    std::snprintf(line, sizeof(line), "\n%-14s %8.2f %8.2f %8.2f %8.1f %7.1f %% %6.1f m %11d  ",
                  world.scene().robots[i].name.c_str(), at.x(), at.y(), at.z(),
                  robot.body.yaw_rad() * 180 / M_PI, robot.battery.percent(), robot.driven_m,
                  robot.collisions);
    text += line + (robot.holds ? NameOfHeld(world, robot) : "-");
  }
  return text;
}

std::string FleetJson(const World& world) {
  char numbers[320];
  std::snprintf(numbers, sizeof(numbers), "%.2f", ToSeconds(world.now()));
  std::string text =
      "{\"name\":" + JsonName(world.scene().name) + ",\"time_s\":" + numbers + ",\"robots\":[";
  for (std::size_t i = 0; i < world.fleet().robots().size(); ++i) {
    const FleetRobot& robot = world.fleet().robots()[i];
    const RobotSpec& spec = world.scene().robots[i];
    const Eigen::Vector3d& at = robot.body.position_m();
    std::snprintf(numbers, sizeof(numbers),
                  R"("x_m":%.3f,"y_m":%.3f,"z_m":%.3f,"yaw_rad":%.4f,"airborne":%s,)"
                  R"("battery_percent":%.2f,"collisions":%d,"driven_m":%.2f,"holds":)",
                  at.x(), at.y(), at.z(), robot.body.yaw_rad(),
                  robot.body.airborne() ? "true" : "false", robot.battery.percent(),
                  robot.collisions, robot.driven_m);
    const char* kind = spec.kind == RobotKind::kFlyer ? "flyer" : "ground";
    text += std::string(i > 0 ? "," : "") + "{\"name\":" + JsonName(spec.name) + ",\"kind\":\"" +
            kind + "\"," + numbers + (robot.holds ? JsonName(NameOfHeld(world, robot)) : "null") +
            "}";
  }
  return text + "]}";
}

}  // namespace musher::world
