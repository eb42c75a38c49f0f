#include "musher/modules/navigation/server/robot_table.hpp"

#include <algorithm>

#include "musher/base/toml/names.hpp"
#include "musher/navigation/gate/gate_toml.hpp"

namespace musher::navigation::config {

using config_toml::TableReader;

void SetNumber(TableReader& reader, std::string_view key, double least, double most,
               double& value) {
  value = reader.Number(key, least, most).value_or(value);
}

void SetTime(TableReader& reader, std::string_view key, Duration& value) {
  value = reader.Time(key).value_or(value);
}

void SetTopic(TableReader& reader, std::string_view key, std::string& value, bool may_be_empty) {
  const auto topic = reader.Topic(key, "jetbot_0/odom", {.may_be_empty = may_be_empty});
  if (topic) value = topic->text;
}

void SetFrame(TableReader& reader, std::string& value) {
  const auto frame = reader.String("frame");
  if (!frame) return;
  if (frame->text.empty()) {
    reader.Fault(frame->at, "frame", "expected the frame of the map, as in \"map\"");
  }
  value = frame->text;
}

void ReadTf(TableReader& root, TfSource& tf) {
  SetTopic(root, "tf", tf.topic, true);
  SetTime(root, "tf_stale_ms", tf.stale);
}

void ReadMemory(TableReader& root, LocalGridRules& rules) {
  SetNumber(root, "memory_m", 1, 50, rules.side_m);
  SetTime(root, "memory_ms", rules.decay);
}

void ReadName(TableReader& reader, const std::vector<std::string>& names, std::string& name) {
  reader.Require("name", "the name of the robot, as in \"jetbot_0\"");
  const auto word = reader.String("name");
  if (!word) return;
  name = word->text;
  if (!config_toml::IsName(name)) {
    reader.Fault(word->at, "name", "expected " + std::string(config_toml::kNameRule));
  } else if (std::find(names.begin(), names.end(), name) != names.end()) {
    reader.Fault(word->at, "name", "another table has the robot \"" + name + "\"");
  }
}

void ReadRobot(TableReader& reader, const std::vector<std::string>& names, RobotTable& robot) {
  ReadName(reader, names, robot.name);
  robot.flies = reader.Choice<bool>("kind", {{"ground", false}, {"flyer", true}}).value_or(false);
  robot.odometry = robot.name + "/odom";
  SetNumber(reader, "radius_m", 0.01, 10, robot.radius_m);
  SetNumber(reader, "margin_m", 0, 10, robot.margin_m);
  SetTopic(reader, "odometry", robot.odometry);
  std::string scan = robot.name + "/scan";
  SetTopic(reader, "scan", scan, true);
  robot.scanners = ReadScanners(reader, scan);
}

}  // namespace musher::navigation::config
