#include "musher/modules/skills/nav2/routed_robot.hpp"

#include <optional>
#include <utility>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/trajectory/rounded_path.hpp"

namespace musher::skills {
namespace {

using tree::nav2::TaskEnd;

constexpr Duration kRouteLimit = std::chrono::seconds(10);  // the client has a shorter one

navigation::Pose PoseFromTree(const tree::nav2::Pose& pose) {
  return {{pose.x_m, pose.y_m, pose.z_m}, pose.yaw_rad};
}
tree::nav2::Path PathToTree(const navigation::Path& path) {
  tree::nav2::Path poses;
  for (const navigation::Pose& pose : path) {
    poses.poses.push_back(
        {.x_m = pose.at.x_m, .y_m = pose.at.y_m, .z_m = pose.at.z_m, .yaw_rad = pose.yaw_rad});
  }
  return poses;
}
tree::nav2::Route RouteToTree(const PlannedRoute& planned) {
  tree::nav2::Route route{{}, planned.edges, planned.cost};
  for (const PlannedRoute::Node& node : planned.nodes) {
    route.nodes.push_back({node.id, node.at.x_m, node.at.y_m, node.at.z_m});
  }
  return route;
}
RouteGoal GoalFromTree(const tree::nav2::RouteRequest& request) {
  RouteGoal goal{
      request.by_poses, {}, PoseFromTree(request.goal), request.start_id, request.goal_id};
  if (request.start) goal.start = PoseFromTree(*request.start);
  return goal;
}

// With the code of nav2_msgs/ComputeRoute.
TaskEnd FailedRoute(const Error& error) {
  using navigation::Fault;
  const auto is = [&error](Fault fault) { return navigation::Is(error, fault); };
  TaskEnd end{.error_code = tree::nav2::kRouteUnknown, .error = error.message};
  if (is(Fault::kOdometry) || is(Fault::kFrame)) end.error_code = tree::nav2::kRoutePose;
  if (is(Fault::kMap)) end.error_code = tree::nav2::kNoValidGraph;
  if (is(Fault::kOutside)) end.error_code = tree::nav2::kNotOnGraph;
  if (is(Fault::kWalledIn)) end.error_code = tree::nav2::kNoValidRoute;
  if (is(Fault::kTimeLimit) || error.code == kCodeNetError) {
    end.error_code = tree::nav2::kRouteTimeout;
  }
  return end;
}

class RouteTask : public tree::nav2::Task {
 public:
  explicit RouteTask(skill::Future<PlannedRoute> route) : route_(std::move(route)) {}

  std::optional<TaskEnd> Poll(Time now) override {
    if (!route_.valid()) return TaskEnd{.error = "there is no route server"};
    if (!route_.done()) {
      if (!begin_) begin_ = now;
      if (now - *begin_ < kRouteLimit) return std::nullopt;
      return TaskEnd{.error_code = tree::nav2::kRouteTimeout, .error = "no answer"};
    }
    if (!route_.result()) return FailedRoute(route_.result().error());
    const PlannedRoute& route = route_.result().value();
    return TaskEnd{.success = true, .path = PathToTree(route.path), .route = RouteToTree(route)};
  }

 private:
  skill::Future<PlannedRoute> route_;
  std::optional<Time> begin_;
};

class TrackTask : public tree::nav2::Task {
 public:
  explicit TrackTask(std::unique_ptr<TrackedRoute> route) : route_(std::move(route)) {}

  std::optional<TaskEnd> Poll(Time /*now*/) override {
    if (route_ == nullptr) return TaskEnd{.error = "there is no route server"};
    const RouteReport& report = route_->report();
    if (report.count != progress_.reports) {
      progress_ = {report.last_node,
                   report.next_node,
                   report.edge,
                   RouteToTree(report.route),
                   PathToTree(report.route.path),
                   report.rerouted,
                   report.count};
    }
    const skill::Future<bool> end = route_->end();
    if (!end.done()) return std::nullopt;
    if (!end.result()) return FailedRoute(end.result().error());
    return TaskEnd{.success = true};
  }
  const tree::nav2::RouteProgress* progress() const override { return &progress_; }

 private:
  const std::unique_ptr<TrackedRoute> route_;
  tree::nav2::RouteProgress progress_;
};

// It is done at once.
class SmoothTask : public tree::nav2::Task {
 public:
  SmoothTask(const TreeRobot& robot, navigation::Path path, bool check)
      : robot_(robot), path_(std::move(path)), checks_(check) {}

  std::optional<TaskEnd> Poll(Time /*now*/) override {
    const auto rounded = navigation::RoundCorners(path_);
    if (!rounded) {
      return TaskEnd{.error_code = tree::nav2::kPathToSmoothInvalid,
                     .error = rounded.error().message};
    }
    TaskEnd end{.success = true, .path = PathToTree(rounded.value())};
    if (!checks_ || robot_.IsFree(end.path)) return end;
    return TaskEnd{.error_code = tree::nav2::kSmoothedPathInCollision,
                   .error = "the robot sees something on the path, or does not see"};
  }

 private:
  const TreeRobot& robot_;
  const navigation::Path path_;
  const bool checks_;
};

}  // namespace

std::unique_ptr<tree::nav2::Task> RoutedRobot::ComputeRoute(
    const tree::nav2::RouteRequest& request) {
  return std::make_unique<RouteTask>(routes_.Ready() ? routes_.ComputeRoute(GoalFromTree(request))
                                                     : skill::Future<PlannedRoute>());
}

std::unique_ptr<tree::nav2::Task> RoutedRobot::TrackRoute(const tree::nav2::RouteRequest& request) {
  return std::make_unique<TrackTask>(routes_.Ready() ? routes_.TrackRoute(GoalFromTree(request))
                                                     : nullptr);
}

bool RoutedRobot::CancelRoutes() {
  if (!routes_.Ready()) return false;
  routes_.CancelTracked();
  return true;
}

std::unique_ptr<tree::nav2::Task> RoutedRobot::SmoothPath(const tree::nav2::Path& path,
                                                          const std::string& /*smoother*/,
                                                          bool check) {
  navigation::Path poses;
  for (const tree::nav2::Pose& pose : path.poses) poses.push_back(PoseFromTree(pose));
  return std::make_unique<SmoothTask>(*this, std::move(poses), check);
}

}  // namespace musher::skills
