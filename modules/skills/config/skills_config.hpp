#pragma once
// The config of musher-skills: which robot, its topics and what it has. A TOML file; every key is
// explained in config/skills/jetbot_0.toml.
//
// Reading reports all errors at once, with line and column.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/navigation/gate/motion_gate.hpp"
#include "musher/navigation/gate/motion_guard.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::skills {

// Topics, services and actions; relative ones are in the machine's namespace. Empty: none.
struct InterfaceNames {
  std::string velocity;       // geometry_msgs/Twist, published
  std::string odometry;       // nav_msgs/Odometry
  std::string objects;        // musher_msgs/ObjectStates
  std::string line;           // musher_msgs/YellowLines
  std::string planner;        // action nav2_msgs/ComputePathToPose
  std::string controller;     // action nav2_msgs/FollowPath
  std::string hand;           // service musher_msgs/ManipulationControl
  std::string teleop;         // geometry_msgs/Twist of a person
  std::string refuge;         // service musher_msgs/ComputeRefuge
  std::string clear_planner;  // services std_srvs/Trigger: what was seen is forgotten
  std::string clear_controller;
  std::string robot_paths;  // musher_msgs/RobotPath of all robots
  // Actions of nav2 that it serves.
  std::string navigate_to_pose;
  std::string navigate_through_poses;
  std::string follow_waypoints;
  std::string tf;       // tf2_msgs/TFMessage; beside it <tf>_static
  std::string battery;  // sensor_msgs/BatteryState
  // geometry_msgs/PoseStamped, as RViz's button for a goal publishes it.
  std::string goal_pose;
  std::string detections;  // musher_msgs/ObjectStates of a detector, on the body
  std::string map;         // nav_msgs/OccupancyGrid
};

// The ground that the picture of the line shows, as if the camera looked straight down.
struct LineView {
  double width_m = 0.8;  // from its left to its right edge
  double depth_m = 0.6;  // from its lower to its upper edge
};

// A detector of the vision module, and the camera through which it looks.
struct DetectorView {
  std::string name;         // the category of what it sees: "qr"
  std::string topic;        // musher_msgs/Sighting
  double width_m = 0;       // of what it sees: its distance, where the detector does not know it
  double fov_rad = 0;       // the angle from the left to the right edge of the picture
  navigation::Pose camera;  // in the frame of the body; yaw 0: it looks ahead
};

struct SkillsConfig {
  std::string file;  // of the diagnostics about it
  std::string robot;
  std::string kind;
  config_toml::Position kind_at;
  bool flies = false;
  double radius_m = 0.25;
  // Of the body, also of a person who teleoperates it: a pose that moves faster has jumped.
  double speed_m_s = navigation::GuardRules{}.speed_m_s;
  double yaw_rad_s = navigation::GuardRules{}.yaw_rad_s;
  std::optional<double> ceiling_m;  // above the zero of the map
  bool hand = false;
  // With a battery at or below it, that does not charge, no skill moves it, and a flyer lands.
  double low_battery_percent = 0;
  int priority = 0;  // where two robots meet; the higher one goes first
  // With the skills that ran when the process was killed; else they have failed.
  bool goes_on_after_restart = false;
  InterfaceNames names;
  navigation::GateRules gate;  // with its scanners
  LineView line;
  std::vector<std::pair<std::string, std::string>> cameras;  // name, topic sensor_msgs/Image
  std::vector<DetectorView> detectors;  // empty: skills detect the objects of names.objects
  std::string photo_folder;             // absolute
  std::string skill_config;             // absolute path of the groups and limits; empty: all skills
  Duration tf_stale = Milliseconds(1000);         // an older transform is not used
  Duration self_check_time = Milliseconds(5000);  // of the steady clock
};

// Never throws; an unreadable file is a diagnostic.
Parsed<SkillsConfig> ReadSkillsFile(const std::string& path);
// The same for a text; `path` is what diagnostics refer to, and relative paths are in its folder.
Parsed<SkillsConfig> ReadSkillsText(std::string_view text, const std::string& path);

}  // namespace musher::skills
