#include "musher/modules/skills/config/skills_config.hpp"

#include <cmath>
#include <filesystem>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/navigation/gate/gate_toml.hpp"

namespace musher::skills {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr double kFlyerLowPercent = 10;
constexpr double kCommandPeriodS = 0.05;  // a scan is followed by a command at once, others wait

class Reader {
 public:
  Reader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {
    config_.file = path;
  }

  SkillsConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    config_.robot = Name(root, "robot", "the robot's name, as in \"jetbot_0\"");
    config_.kind = Name(root, "kind", "the kind of robot, as in \"jetbot\"");
    config_.kind_at = root.At("kind");
    config_.radius_m = root.Number("radius_m", 0.01, 10).value_or(config_.radius_m);
    config_.speed_m_s = root.Number("speed_m_s", 0.01, 20).value_or(config_.speed_m_s);
    config_.yaw_rad_s = root.Number("yaw_rad_s", 0.01, 20).value_or(config_.yaw_rad_s);
    config_.flies = root.Bool("flies").value_or(false);
    config_.goes_on_after_restart =
        root.Choice<bool>("after_restart", {{"fail", false}, {"continue", true}}).value_or(false);
    config_.ceiling_m = root.Number("ceiling_m", 0.1, 10'000);
    config_.hand = root.Bool("hand").value_or(false);
    config_.priority = static_cast<int>(root.Integer("priority", -1000, 1000).value_or(0));
    config_.self_check_time = root.Time("self_check_ms").value_or(config_.self_check_time);
    config_.tf_stale = root.Time("tf_stale_ms").value_or(config_.tf_stale);
    config_.photo_folder = PathOf(root, "photo_folder",
                                  config_toml::DefaultStateDir("photos", "") + "/" + config_.robot);
    config_.skill_config = PathOf(root, "skill_config", "");
    SetNames();
    if (const Table* topics = root.SubTable("topics")) {
      TableReader reader(*topics, root.At("topics"), "topics", findings_);
      ReadTopics(reader);
      reader.RefuseOthers();
    }
    if (const Table* line = root.SubTable("line")) {
      TableReader reader(*line, root.At("line"), "line", findings_);
      config_.line.width_m = reader.Number("width_m", 0.01, 10).value_or(config_.line.width_m);
      config_.line.depth_m = reader.Number("depth_m", 0.01, 10).value_or(config_.line.depth_m);
      reader.RefuseOthers();
    }
    if (config_.flies) config_.low_battery_percent = kFlyerLowPercent;
    if (const Table* battery = root.SubTable("battery")) {
      TableReader reader(*battery, root.At("battery"), "battery", findings_);
      config_.low_battery_percent =
          reader.Number("low_percent", 0, 99).value_or(config_.low_battery_percent);
      reader.RefuseOthers();
    }
    config_.gate.radius_m = config_.radius_m;
    config_.gate.scanners = navigation::ReadScanners(root, scan_);
    if (config_.flies) config_.gate.blind_m_s = navigation::kFlyerBlindMS;
    config_.gate.reaction_s += kCommandPeriodS;
    navigation::ReadGate(root, config_.gate);
    ReadCameras(root);
    ReadDetectors(root);
    root.RefuseOthers();
    return config_;
  }

 private:
  static std::string Name(TableReader& root, std::string_view key, std::string_view expected) {
    root.Require(key, expected);
    const std::optional<Word> name = root.String(key);
    if (!name) return "";
    if (!config_toml::IsName(name->text)) {
      root.Fault(name->at, key,
                 "expected " + std::string(config_toml::kNameRule) + ", found " +
                     config_toml::Quote(name->text));
    }
    return name->text;
  }

  std::string PathOf(TableReader& root, std::string_view key, const std::string& otherwise) {
    const std::optional<Word> path = root.String(key);
    const std::string text = path ? path->text : otherwise;
    if (path && text.empty()) root.Fault(path->at, key, "expected a path, found an empty text");
    return text.empty() ? "" : config_toml::Absolute(folder_, text);
  }

  void SetNames() {
    const std::string prefix = config_.robot + "/";
    scan_ = prefix + "scan";
    config_.names = {prefix + "cmd_vel",
                     prefix + "odom",
                     "world/objects",
                     "",
                     prefix + "compute_path_to_pose",
                     prefix + "follow_path",
                     prefix + "manipulation_control",
                     "",
                     prefix + "compute_refuge",
                     prefix + "clear_planner_memory",
                     prefix + "clear_controller_memory",
                     "/robot_paths",
                     prefix + "navigate_to_pose",
                     prefix + "navigate_through_poses",
                     prefix + "follow_waypoints",
                     "/tf",
                     prefix + "battery",
                     prefix + "goal_pose",
                     prefix + "detections",
                     "map"};
  }

  void ReadTopics(TableReader& reader) {
    InterfaceNames& names = config_.names;
    Topic(reader, "velocity", names.velocity, false);
    Topic(reader, "odometry", names.odometry, false);
    Topic(reader, "scan", scan_, true);
    Topic(reader, "objects", names.objects, true);
    Topic(reader, "line", names.line, true);
    Topic(reader, "detections", names.detections, true);
    Topic(reader, "map", names.map, true);
    Topic(reader, "planner", names.planner, false);
    Topic(reader, "controller", names.controller, false);
    Topic(reader, "hand", names.hand, false);
    Topic(reader, "teleop", names.teleop, true);
    Topic(reader, "refuge", names.refuge, false);
    Topic(reader, "clear_planner", names.clear_planner, true);
    Topic(reader, "clear_controller", names.clear_controller, true);
    Topic(reader, "robot_paths", names.robot_paths, true);
    Topic(reader, "navigate_to_pose", names.navigate_to_pose, true);
    Topic(reader, "navigate_through_poses", names.navigate_through_poses, true);
    Topic(reader, "follow_waypoints", names.follow_waypoints, true);
    Topic(reader, "goal_pose", names.goal_pose, true);
    Topic(reader, "tf", names.tf, true);
    Topic(reader, "battery", names.battery, true);
  }

  static void Topic(TableReader& reader, std::string_view key, std::string& name, bool optional) {
    const auto topic = reader.Topic(key, "jetbot_0/odom",
                                    {.of = "a topic, service or action", .may_be_empty = optional});
    if (topic) name = topic->text;
  }

  void ReadCameras(TableReader& root) {
    const Table* cameras = root.SubTable("cameras");
    if (cameras == nullptr) return;
    TableReader reader(*cameras, root.At("cameras"), "cameras", findings_);
    for (const config_toml::Member& member : *cameras) {
      std::string topic;
      Topic(reader, member.key, topic, false);
      config_.cameras.emplace_back(member.key, topic);
    }
  }

  void ReadDetectors(TableReader& root) {
    const Table* detectors = root.SubTable("detector");
    if (detectors == nullptr) return;
    TableReader all(*detectors, root.At("detector"), "detector", findings_);
    for (const config_toml::Member& member : *detectors) {
      const Table* table = all.SubTable(member.key);
      if (table == nullptr) continue;
      TableReader reader(*table, all.At(member.key), "detector." + member.key, findings_);
      config_.detectors.push_back(Detector(reader, member.key));
      reader.RefuseOthers();
    }
  }

  static DetectorView Detector(TableReader& reader, const std::string& name) {
    constexpr double kDegree = M_PI / 180;
    DetectorView view;
    view.name = name;
    reader.Require("topic", "a topic of the vision module, as in \"/qr_detector/sighting\"");
    Topic(reader, "topic", view.topic, false);
    reader.Require("width_m", "the width of what it sees");
    view.width_m = reader.Number("width_m", 0.001, 100).value_or(1);
    reader.Require("fov_deg", "the horizontal angle of the camera's picture");
    view.fov_rad = reader.Number("fov_deg", 1, 170).value_or(60) * kDegree;
    view.camera.at = {reader.Number("camera_x_m", -10, 10).value_or(0),
                      reader.Number("camera_y_m", -10, 10).value_or(0),
                      reader.Number("camera_z_m", -10, 10).value_or(0)};
    view.camera.yaw_rad = reader.Number("camera_yaw_deg", -180, 180).value_or(0) * kDegree;
    return view;
  }

  const std::filesystem::path folder_;
  Findings& findings_;
  SkillsConfig config_;
  std::string scan_;  // the topic of the only scanner
};

}  // namespace

Parsed<SkillsConfig> ReadSkillsText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<SkillsConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Reader(path, findings).Read(root); });
}

Parsed<SkillsConfig> ReadSkillsFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadSkillsText);
}

}  // namespace musher::skills
