#pragma once
// What the files of planner_server and controller_server have in common: a table [[robot]] for each
// robot, and how their keys are read. Metres, seconds.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::navigation {

// [[robot]]: a round body and its topics, which are relative to the machine's namespace.
struct RobotTable {
  std::string name;
  bool flies = false;     // kind = "flyer"
  double radius_m = 0.2;  // of the body
  double margin_m = 0.1;  // between the body and an obstacle, at least
  std::string odometry;   // <name>/odom
  std::string scan;       // <name>/scan; empty: it has no scanner
};

namespace config {

void SetNumber(config_toml::TableReader& reader, std::string_view key, double least, double most,
               double& value);
void SetTime(config_toml::TableReader& reader, std::string_view key, Duration& value);
// A topic; an empty one only if `may_be_empty`.
void SetTopic(config_toml::TableReader& reader, std::string_view key, std::string& value,
              bool may_be_empty = false);

// The keys of `robot`; reports a name that one of `names` has.
void ReadRobot(config_toml::TableReader& reader, const std::vector<std::string>& names,
               RobotTable& robot);

}  // namespace config
}  // namespace musher::navigation
