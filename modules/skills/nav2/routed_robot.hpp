#pragma once
// A TreeRobot with a route server, for the trees of nav2 with routes:
//
//   skills::RouteClient routes(endpoints, "jetbot_0/compute_route",
//                              "jetbot_0/compute_and_track_route");
//   skills::RoutedRobot nav2(robot, routes);
//   tree::nav2::AddNodes(factory, nav2);
//
// SmoothPath rounds the corners of a path here, in this process, by 0.1 m at most; the name of a
// smoother is ignored.
//
// Frames and units of robot.hpp. Threads: the loop of the actuator.

#include <memory>
#include <string>

#include "musher/modules/skills/nav2/tree_robot.hpp"
#include "musher/modules/skills/robot/route_client.hpp"

namespace musher::skills {

class RoutedRobot : public TreeRobot {
 public:
  // Both must outlive it; it must outlive the trees.
  RoutedRobot(skills::Robot& robot, RouteClient& routes) : TreeRobot(robot), routes_(routes) {}

  std::unique_ptr<tree::nav2::Task> ComputeRoute(const tree::nav2::RouteRequest& request) override;
  std::unique_ptr<tree::nav2::Task> TrackRoute(const tree::nav2::RouteRequest& request) override;
  bool CancelRoutes() override;
  std::unique_ptr<tree::nav2::Task> SmoothPath(const tree::nav2::Path& path,
                                               const std::string& smoother, bool check) override;

 private:
  RouteClient& routes_;
};

}  // namespace musher::skills
