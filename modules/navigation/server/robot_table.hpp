#pragma once
// What the files of planner_server and controller_server have in common: a table [[robot]] for each
// robot, and how their keys are read. Metres, seconds.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/navigation/gate/scan_view.hpp"
#include "musher/navigation/grid/local_grid.hpp"

namespace musher::navigation {

// [[robot]]: a round body and its topics, which are relative to the machine's namespace.
struct RobotTable {
  std::string name;
  bool flies = false;               // kind = "flyer"
  double radius_m = 0.2;            // of the body
  double margin_m = 0.1;            // between the body and an obstacle, at least
  std::string odometry;             // <name>/odom
  std::vector<ScanMount> scanners;  // [[robot.scanner]], or one on `scan` (<name>/scan)
  std::string clear_memory;         // <name>/clear_planner_memory or …/clear_controller_memory
};

// Where frames lie in each other: that of the odometry in the map, scanners on the bodies.
struct TfSource {
  std::string topic = "/tf";  // tf2_msgs/TFMessage; beside it <topic>_static; empty: none
  Duration stale = Milliseconds(1000);
};

namespace config {

void ReadTf(config_toml::TableReader& root, TfSource& tf);
void SetNumber(config_toml::TableReader& reader, std::string_view key, double least, double most,
               double& value);
void SetTime(config_toml::TableReader& reader, std::string_view key, Duration& value);
// A topic; an empty one only if `may_be_empty`.
void SetTopic(config_toml::TableReader& reader, std::string_view key, std::string& value,
              bool may_be_empty = false);

// The frame of the map; not empty.
void SetFrame(config_toml::TableReader& reader, std::string& value);

// What robots remember of what they have seen.
void ReadMemory(config_toml::TableReader& root, LocalGridRules& rules);

// The name of a robot; reports one that `names` has.
void ReadName(config_toml::TableReader& reader, const std::vector<std::string>& names,
              std::string& name);

// The keys of `robot`, with its name.
void ReadRobot(config_toml::TableReader& reader, const std::vector<std::string>& names,
               RobotTable& robot);

// All tables [[robot]], at least one; `read` reads the one of a robot.
template <class Robot>
std::vector<Robot> ReadRobots(config_toml::TableReader& root, config_toml::Findings& findings,
                              Robot (*read)(config_toml::TableReader& reader,
                                            const std::vector<std::string>& names)) {
  root.Require("robot", "a table [[robot]] for each robot");
  std::vector<Robot> robots;
  std::vector<std::string> names;
  for (const config_toml::Value* value : root.Tables("robot")) {
    config_toml::TableReader reader(*value->As<config_toml::Table>(), value->at, "robot", findings);
    robots.push_back(read(reader, names));
    names.push_back(robots.back().name);
  }
  return robots;
}

}  // namespace config
}  // namespace musher::navigation
