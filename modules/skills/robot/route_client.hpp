#pragma once
// The route server of a robot (musher-route, or nav2's): its requests of routes, and the routes
// that it tracks, as goals of the server's actions.
//
//   request  sent ──→ route or reason.
//   tracked  sent ──→ reports ──→ at its end, or failed. Its goal is cancelled when it is destroyed
//            before; once, since it moves nothing.
//
// Metres, radians, the frame of the map; a route in another frame is not used. Errors of routes, by
// their codes: navigation::Fault::kOdometry, the server does not know where the robot is; kMap, it
// has another graph; kOutside, start or goal is none of its nodes, or not near one; kWalledIn,
// there is no route; kTimeLimit; kCodeStateInvalid, it rejects the goal, or has another reason;
// kCodeNetError, it does not answer or is lost.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/behavior/skill/future.hpp"
#include "musher/messages/nav2_msgs/compute_and_track_route.hpp"
#include "musher/messages/nav2_msgs/compute_route.hpp"
#include "musher/navigation/pose.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::skills {

// A way over the graph of the route server.
struct PlannedRoute {
  struct Node {
    std::uint16_t id = 0;
    navigation::Point at;
  };
  navigation::Path path;  // along it
  std::vector<Node> nodes;
  std::vector<std::uint16_t> edges;  // ids, from each node to the next one
  double cost = 0;
};

struct RouteGoal {
  bool by_poses = false;                  // false: by the ids of nodes
  std::optional<navigation::Pose> start;  // nullopt: where the robot is
  navigation::Pose goal;
  std::uint16_t start_id = 0;
  std::uint16_t goal_id = 0;
};

// How far the robot is along a route.
struct RouteReport {
  std::uint16_t last_node = 0;  // 0 also: none
  std::uint16_t next_node = 0;
  std::uint16_t edge = 0;
  PlannedRoute route;
  bool rerouted = false;    // it is another route than in the report before
  std::uint64_t count = 0;  // of the reports
};

// A route along which the server watches the robot. One that is destroyed before its end is
// cancelled.
class TrackedRoute {
 public:
  virtual ~TrackedRoute() = default;
  virtual const RouteReport& report() const = 0;  // the last one; `count` 0: none yet
  // True: the robot is at its end. An error: why it has failed, or was refused.
  virtual skill::Future<bool> end() const = 0;
};

class RouteClient {
 public:
  // The endpoints must outlive it. The names of the actions: "jetbot_0/compute_route",
  // "jetbot_0/compute_and_track_route".
  RouteClient(transport::Endpoints& endpoints, const std::string& route, const std::string& track);
  // Its routes are cancelled no more.
  ~RouteClient() { *tracks_ = nullptr; }
  RouteClient(const RouteClient&) = delete;
  RouteClient& operator=(const RouteClient&) = delete;

  // Whether the server can be reached now.
  bool Ready() const { return computes_ != nullptr && computes_->Ready(); }
  skill::Future<PlannedRoute> ComputeRoute(const RouteGoal& goal);
  std::unique_ptr<TrackedRoute> TrackRoute(const RouteGoal& goal);
  // Cancels all routes that the server tracks now, for every client, and the own ones that wait for
  // it. Once: a request that is lost is not repeated.
  void CancelTracked();

 private:
  using Computes = transport::ActionClient<msg::ComputeRoute>;
  using Tracks = transport::ActionClient<msg::ComputeAndTrackRoute>;
  struct TrackGoal;
  class GoalRoute;

  template <class Goal>
  Goal ToMessage(const RouteGoal& goal) const;

  const std::function<msg::Stamp()> stamp_;
  Computes* const computes_;               // null: not opened
  const std::shared_ptr<Tracks*> tracks_;  // for routes that outlive this object; null then
  std::vector<std::weak_ptr<TrackGoal>> tracked_;
};

}  // namespace musher::skills
