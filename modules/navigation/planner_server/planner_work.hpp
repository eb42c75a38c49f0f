#pragma once
// The work of planner_server without a network: maps become planners, requests become paths. Every
// failure has a code of Fault, and an error code of nav2 for the client. Pure, apart from `stop`;
// any thread. Metres, radians, the frame of the map.

#include <functional>
#include <vector>

#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/modules/navigation/messages/conversions.hpp"
#include "musher/modules/navigation/planner_server/planner_config.hpp"
#include "musher/navigation/planner/planner.hpp"
#include "musher/navigation/traffic/right_of_way.hpp"

namespace musher::navigation {

using PathCode = msg::ComputePathToPose;

// Of a robot on the ground; the body has room for its radius and margin. `keep_out`: cells that no
// path touches; null: none.
Result<Planner> MakePlanner(const msg::OccupancyGrid& grid, const PlannerConfig& config,
                            const PlannerRobot& robot, const CellMap* keep_out = nullptr);
// Of a flyer, between the ground and the ceiling.
Result<Planner> MakePlanner(const msg::PointCloud2& cloud, const PlannerConfig& config,
                            const PlannerRobot& robot, const CellMap* keep_out = nullptr);

struct PathRequest {
  Pose start;
  Pose goal;
  std::vector<Point> seen;  // by the robot's scan
  // The last path to this goal by this map, along which the robot still drives; empty: none. Then a
  // way around what is seen is sought near the robot, and on the whole map only if there is none.
  Path before{};
};

struct PathReply {
  Result<Plan> plan;
  std::uint16_t error_code = 0;  // of nav2_msgs/ComputePathToPose; NONE for a plan
  bool around_seen = false;      // the plan avoids points that the map does not have
};

// What is seen and the map does not have blocks the path, where there is a path around it. Where
// there is none the plan is that of the map alone: what blocks it may move.
PathReply FindPath(const Planner& planner, const PathRequest& request, const PlannerConfig& config,
                   const PlannerRobot& robot, const std::function<bool()>& stop);

struct RefugeRequest {
  Pose start;
  std::vector<Point> seen;          // by the robot's scan
  std::vector<RobotIntent> others;  // off their paths, and not through their bodies
};

// The path to the nearest place that is off the paths of others. It looks within 25 m.
Result<Plan> FindRefuge(const Planner& planner, const RefugeRequest& request,
                        const PlannerRobot& robot, const std::function<bool()>& stop);

// The code of nav2 for a failure.
std::uint16_t ErrorCodeOf(const Error& error);

}  // namespace musher::navigation
