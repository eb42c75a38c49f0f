// The nodes of nav2 for routes over a graph of places, and for the path that is made of one.

#include <cmath>

#include "musher/behavior/tree/nav2/register.hpp"
#include "musher/behavior/tree/nav2/task_node.hpp"

namespace musher::tree::nav2 {
namespace {

// ComputeRoute and ComputeAndTrackRoute.
class RouteNode : public TaskNode {
 protected:
  RouteNode(Setup& setup, Robot& robot)
      : TaskNode(setup, kRouteUnknown),
        start_id_(setup.OptionalInput<std::uint16_t>("start_id", "node where it begins")),
        goal_id_(setup.OptionalInput<std::uint16_t>("goal_id", "node where it ends")),
        start_(setup.OptionalInput<Pose>("start", "where it begins, with `use_start`")),
        goal_(setup.OptionalInput<Pose>("goal", "where it ends")),
        uses_start_(setup.Input<bool>("use_start", false,
                                      "true: from `start`; false: from where the robot is")),
        uses_poses_(setup.Input<bool>("use_poses", false,
                                      "true: `start` and `goal`; false: `start_id` and "
                                      "`goal_id`")),
        route_(setup.Output<Route>("route", "its nodes and edges; empty after a failure")),
        path_(setup.Output<Path>("path", "the path along it; empty after a failure or a halt")),
        robot_(robot) {}

  RouteRequest Request() const {
    RouteRequest request{.by_poses = uses_poses_.Get()};
    if (request.by_poses) {
      request.goal = goal_.Get();
      if (uses_start_.Get()) request.start = start_.Get();
    } else {
      request.start_id = start_id_.Get();
      request.goal_id = goal_id_.Get();
    }
    return request;
  }
  void SetRoute(const Route& route, const Path& path) {
    route_.Set(route);
    path_.Set(path);
  }
  Robot& robot() { return robot_; }

 private:
  InPort<std::uint16_t> start_id_;
  InPort<std::uint16_t> goal_id_;
  InPort<Pose> start_;
  InPort<Pose> goal_;
  InPort<bool> uses_start_;
  InPort<bool> uses_poses_;
  OutPort<Route> route_;
  OutPort<Path> path_;
  Robot& robot_;
};

void DoesNotSet(Setup& setup, std::string_view output) {
  static_cast<void>(
      setup.Connect({std::string(output), Direction::kOut, nullptr, false, "is not set"}));
}

class ComputeRoute : public RouteNode {
 public:
  ComputeRoute(Setup& setup, Robot& robot) : RouteNode(setup, robot) {
    DoesNotSet(setup, "planning_time");
  }

 private:
  std::unique_ptr<Task> Begin() override { return robot().ComputeRoute(Request()); }
  void OnEnd(const TaskEnd& end) override {
    if (end.success) return SetRoute(end.route, end.path);
    SetRoute({}, {});
  }
};

class ComputeAndTrackRoute : public RouteNode {
 public:
  ComputeAndTrackRoute(Setup& setup, Robot& robot)
      : RouteNode(setup, robot),
        last_(setup.Output<std::uint16_t>("last_node_id", "the node it was at last; 0 also: none")),
        next_(setup.Output<std::uint16_t>("next_node_id", "the node it comes to; 0 also: none")),
        edge_(setup.Output<std::uint16_t>("current_edge_id", "between both; 0 also: none")),
        rerouted_(setup.Output<bool>("rerouted", "it has another route than before")) {
    for (const char* port : {"execution_duration", "execution_time"}) DoesNotSet(setup, port);
  }

 private:
  std::unique_ptr<Task> Begin() override {
    seen_ = 0;
    return robot().TrackRoute(Request());
  }
  Status OnRunning(const Tick& tick) override {
    const Status status = Poll(tick.now);
    const RouteProgress* progress = task() != nullptr ? task()->progress() : nullptr;
    if (progress == nullptr || progress->reports == seen_) return status;
    seen_ = progress->reports;
    SetRoute(progress->route, progress->path);
    SetPlace(progress->last_node, progress->next_node, progress->edge);
    rerouted_.Set(progress->rerouted);
    return status;
  }
  // Nothing is known of a route that is over.
  void OnEnd(const TaskEnd& /*end*/) override {
    SetRoute({}, {});
    SetPlace(0, 0, 0);
    rerouted_.Set(false);
  }
  void SetPlace(std::uint16_t last, std::uint16_t next, std::uint16_t edge) {
    last_.Set(last);
    next_.Set(next);
    edge_.Set(edge);
  }

  OutPort<std::uint16_t> last_;
  OutPort<std::uint16_t> next_;
  OutPort<std::uint16_t> edge_;
  OutPort<bool> rerouted_;
  std::uint64_t seen_ = 0;  // reports
};

class CancelComputeAndTrackRoute : public Action {
 public:
  CancelComputeAndTrackRoute(Setup& setup, Robot& robot) : robot_(robot) {
    static_cast<void>(setup.OptionalInput<std::string>("server_name", "ignored"));
    static_cast<void>(setup.OptionalInput<double>("server_timeout", "ignored: ms"));
  }

 private:
  Status Do(const Tick&) override {
    return robot_.CancelRoutes() ? Status::kSuccess : Status::kFailure;
  }

  Robot& robot_;
};

// Places to travel through, that look to the next one; the last one looks as the one before.
class ExtractRouteNodesAsGoals : public Action {
 public:
  explicit ExtractRouteNodesAsGoals(Setup& setup)
      : route_(setup.Input<Route>("route", "the route")),
        goals_(setup.Output<Goals>("goals", "the places of its nodes")) {}

 private:
  Status Do(const Tick&) override {
    const Route& route = route_.Get();
    if (route.nodes.empty()) return Status::kFailure;
    Goals goals;
    for (const Route::Node& node : route.nodes) {
      Pose pose{.x_m = node.x_m, .y_m = node.y_m, .z_m = node.z_m};
      if (!goals.poses.empty()) {
        Pose& before = goals.poses.back();
        before.yaw_rad = std::atan2(pose.y_m - before.y_m, pose.x_m - before.x_m);
        pose.yaw_rad = before.yaw_rad;
      }
      goals.poses.push_back(pose);
    }
    goals_.Set(goals);
    return Status::kSuccess;
  }

  InPort<Route> route_;
  OutPort<Goals> goals_;
};

class SmoothPath : public TaskNode {
 public:
  SmoothPath(Setup& setup, Robot& robot)
      : TaskNode(setup, kSmootherUnknown),
        path_(setup.Input<Path>("unsmoothed_path", "the path")),
        smoother_(setup.OptionalInput<std::string>("smoother_id", "name of a smoother")),
        checks_(setup.Input<bool>("check_for_collisions", false,
                                  "true: it fails where the robot sees something on the path")),
        smoothed_(setup.Output<Path>("smoothed_path", "the path; empty after a failure or a halt")),
        completed_(setup.Output<bool>("was_completed", "whether it has succeeded")),
        robot_(robot) {
    static_cast<void>(setup.OptionalInput<double>("max_smoothing_duration", "ignored: s"));
    DoesNotSet(setup, "smoothing_duration");
  }

 private:
  std::unique_ptr<Task> Begin() override {
    return robot_.SmoothPath(path_.Get(), smoother_.Or(""), checks_.Get());
  }
  void OnEnd(const TaskEnd& end) override {
    smoothed_.Set(end.success ? end.path : Path{});
    completed_.Set(end.success);
  }

  InPort<Path> path_;
  InPort<std::string> smoother_;
  InPort<bool> checks_;
  OutPort<Path> smoothed_;
  OutPort<bool> completed_;
  Robot& robot_;
};

}  // namespace

void AddRouteNodes(Factory& factory, Robot& robot) {
  constexpr NodeKind kKind = NodeKind::kAction;
  AddNode<ComputeRoute>(factory, "ComputeRoute", kKind, true,
                        "Has the route server find a route over its graph.", robot);
  AddNode<ComputeAndTrackRoute>(factory, "ComputeAndTrackRoute", kKind, true,
                                "Has the route server find a route, and watch the robot along it; "
                                "SUCCESS at its end. Another node moves the robot.",
                                robot);
  AddNode<CancelComputeAndTrackRoute>(factory, "CancelComputeAndTrackRoute", kKind, false,
                                      "Has the route server cancel each route that it tracks, also "
                                      "those of other clients. It stops no motion.",
                                      robot);
  AddNode<ExtractRouteNodesAsGoals>(factory, "ExtractRouteNodesAsGoals", kKind, false,
                                    "Makes goals of the nodes of a route, which look along it; "
                                    "FAILURE where it has none.");
  AddNode<SmoothPath>(factory, "SmoothPath", kKind, true,
                      "Makes a path without sharp corners of a path.", robot);
}

}  // namespace musher::tree::nav2
