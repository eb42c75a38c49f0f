#pragma once
// route_server on the network: odometry in; for each robot the actions nav2_msgs/ComputeRoute and
// nav2_msgs/ComputeAndTrackRoute; for all of them the services nav2_msgs/DynamicEdges and
// nav2_msgs/SetRouteGraph. Runs on any transport.
//
// A route is found at once. A tracked one lasts until the robot is at its last node, and moves
// nothing:
//
//   tracked ─→ succeeded   at the last node
//           ─→ aborted     a newer goal; no pose any more; an edge was closed and there is no other
//                          route; another graph; not Active any more
//           ─→ cancelled   by its client. A client that is lost changes nothing.
//
// Feedback comes at its begin, at each node, and with another route. A goal that fails has a code
// of nav2 and its reason, which is logged once. A graph that cannot be used is logged; the one
// before stays.
//
// Threads: the loop's; a graph that a request names is read on a Background.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/rate_limited_log.hpp"
#include "musher/messages/nav2_msgs/compute_and_track_route.hpp"
#include "musher/messages/nav2_msgs/compute_route.hpp"
#include "musher/messages/nav2_msgs/dynamic_edges.hpp"
#include "musher/messages/nav2_msgs/set_route_graph.hpp"
#include "musher/modules/navigation/messages/conversions.hpp"
#include "musher/modules/navigation/route_server/route_config.hpp"
#include "musher/modules/navigation/server/background.hpp"
#include "musher/modules/navigation/server/server_actuator.hpp"
#include "musher/navigation/frames/frame_tree.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::navigation {

class RouteServer {
 public:
  using Config = RouteConfig;

  // `background`: by default a ThreadBackground. The config has a graph.
  static Result<std::unique_ptr<RouteServer>> Make(const Dependencies& dependencies,
                                                   const RouteConfig& config,
                                                   std::unique_ptr<Background> background = {});
  // Present goals are aborted.
  ~RouteServer();

  // Whether goals are accepted. With false the present ones are aborted; `why` is logged.
  void Permit(bool permitted, const std::string& why);
  // The world was restarted: odometry of before is not used, tracked routes are aborted.
  void OnTimeJump(const std::string& why);
  // Whether each robot has odometry.
  SelfCheckResult Check() const;

 private:
  using Compute = msg::ComputeRoute;
  using Track = msg::ComputeAndTrackRoute;
  using TrackGoal = transport::ServerGoal<Track>;

  struct Tracked {
    TrackGoal goal;
    RouteTracker tracker;
    std::size_t to = 0;          // the node where it ends, also where that was left out
    std::optional<Point> place;  // of the goal; nullopt: it is a node
    Time begin;
  };
  struct Robot {
    const RouteRobot* config = nullptr;
    std::optional<Motion> motion;
    Time motion_at;
    std::optional<Tracked> tracked;
  };
  // A goal of either action.
  struct Wanted {
    std::size_t from = 0, to = 0;
    std::optional<Point> start, goal;  // of a goal by poses
    double yaw_rad = 0;                // of a path of one pose
  };

  RouteServer(const Dependencies& dependencies, RouteConfig config,
              std::unique_ptr<Background> background);
  Result<> Open();
  void OpenRobot(Robot& robot);
  void OnOdometry(Robot& robot, const msg::Odometry& odometry);
  void OnCompute(Robot& robot, const transport::ServerGoal<Compute>& goal);
  void OnTrack(Robot& robot, const TrackGoal& goal);
  template <class Goal>
  Result<Wanted> WantedBy(const Robot& robot, const Goal& goal) const;
  Result<Route> RouteFor(const Wanted& wanted) const;
  Result<> CheckPlace(const Robot& robot) const;

  void Follow(Robot& robot);
  void Report(Robot& robot, bool rerouted);
  void Watch();
  void RouteAgain(Robot& robot);
  void End(Robot& robot, const Error& error);
  // The result of a tracked route that has failed.
  Track::Result Failed(const Tracked& tracked, const Error& error) const;
  void Refused(const Robot& robot, const Error& error);
  // Ends the tracked route of a robot.
  void Drop(Robot& robot, const std::string& why);

  msg::DynamicEdges::Response ChangeEdges(const msg::DynamicEdges::Request& request);
  void ReadGraph(const std::string& path, std::function<void(bool)> reply);

  msg::Header HeaderNow() const;
  msg::Route ToMessage(const Route& route) const;
  msg::Path PathOf(const Route& route, double yaw_rad) const;
  void Warn(const std::string& kind, const std::string& what);
  void Log(LogLevel level, const std::string& line) const { dependencies_.log(level, line); }
  Time Now() const { return dependencies_.clock.Now(); }
  bool IsFresh(const Robot& robot) const {
    return robot.motion && Now() - robot.motion_at <= config_.stale;
  }

  const Dependencies dependencies_;
  const RouteConfig config_;
  std::string graph_file_;
  std::shared_ptr<const RouteGraph> graph_;
  EdgeChanges changes_;  // of it
  FrameTree frames_;
  RateLimitedLog warnings_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  std::vector<std::unique_ptr<Robot>> robots_;
  std::unique_ptr<Background> background_;
  transport::LoopHandlePtr ticks_;
  transport::LoopHandlePtr watch_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::navigation
