#pragma once
// The file of musher-planner; config/navigation/planner.toml explains its keys.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/navigation/server/robot_table.hpp"
#include "musher/navigation/grid/local_grid.hpp"

namespace musher::navigation {

struct PlannerRobot : RobotTable {
  double comfort_m = 0.1;  // more room than the margin, where it is cheap
  std::string action;      // <name>/compute_path_to_pose
  std::string path;        // <name>/planned_path
  std::string refuge;      // <name>/compute_refuge
};

struct PlannerConfig {
  std::string frame = "map";
  std::string map = "map";                       // nav_msgs/OccupancyGrid, for the ground
  std::string cloud = "map_point_cloud";         // sensor_msgs/PointCloud2, for the air
  std::string keep_out = "keepout_filter_info";  // nav2_msgs/CostmapFilterInfo; empty: none
  Duration limit = Milliseconds(5000);           // of a request
  Duration stale = Milliseconds(500);            // older odometry and scans are not used
  Duration self_check_time = Milliseconds(5000);
  int blocked_from = 65;  // per cent, of a cell of the map
  bool unknown_is_free = false;
  double cloud_resolution_m = 0.1;
  double cloud_margin_m = 1;  // of free space around the points
  double ceiling_m = 3;       // flyers stay below
  LocalGridRules memory;      // of what scans have seen
  TfSource tf;
  std::vector<PlannerRobot> robots;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<PlannerConfig> ReadPlannerFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<PlannerConfig> ReadPlannerText(std::string_view text, const std::string& path);

}  // namespace musher::navigation
