#pragma once
// The file of musher-controller; config/navigation/controller.toml explains its keys.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/navigation/server/robot_table.hpp"
#include "musher/navigation/controller/follower.hpp"
#include "musher/navigation/controller/progress_check.hpp"
#include "musher/navigation/gate/motion_gate.hpp"

namespace musher::navigation {

struct ControllerRobot : RobotTable {
  // Drives ahead and turns, never aside; false for bodies that move in every direction.
  bool differential = true;
  MotionLimits limits;
  double lag_s = 0;  // of the body behind the command, 0 if not known
  double arrive_m = 0.2;
  double arrive_rad = 0.1;
  double join_m = 2;       // how far from the robot a path may begin
  GateRules gate;          // [robot.gate]
  std::string action;      // <name>/follow_path
  std::string trajectory;  // <name>/timed_trajectory
  std::string command;     // <name>/cmd_vel
  bool stamped = false;    // the command is a TwistStamped, as nav2 has it since Kilted
};

struct NamedGoalChecker {
  std::string name;
  double arrive_m = 0.2;
  double arrive_rad = 0.1;
};

struct NamedProgressChecker {
  std::string name;
  ProgressRules rules;
};

struct ControllerConfig {
  std::string frame = "map";
  std::string map = "map";                  // of robots on the ground; empty: none
  std::string cloud = "map_point_cloud";    // of flyers; empty: none
  std::string speed_limit = "speed_limit";  // nav2_msgs/SpeedLimit; empty: none
  // nav2_msgs/CostmapFilterInfo; empty: none
  std::string keep_out = "keepout_filter_info";
  std::string speed_mask = "speed_filter_info";
  double cloud_resolution_m = 0.1;
  Duration odometry_stale = Milliseconds(400);  // older odometry ends a drive
  Duration scan_stale = Milliseconds(1000);
  Duration obstacle_time = Milliseconds(2000);  // with an obstacle in the way
  Duration late = Milliseconds(5000);           // after the trajectory's time
  Duration self_check_time = Milliseconds(5000);
  LocalGridRules memory;  // of what scans have seen
  TfSource tf;
  // By the ids of a goal. Without any of a kind, ids of it are not used.
  std::vector<NamedGoalChecker> goal_checkers;
  std::vector<NamedProgressChecker> progress_checkers;
  std::vector<ControllerRobot> robots;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<ControllerConfig> ReadControllerFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<ControllerConfig> ReadControllerText(std::string_view text, const std::string& path);

}  // namespace musher::navigation
