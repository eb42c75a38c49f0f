#include "musher/modules/navigation/route_server/route_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>

#include "musher/base/toml/names.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/navigation/server/robot_endpoints.hpp"
#include "musher/modules/navigation/server/thread_background.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr Duration kQuietTimeOfRoutes = std::chrono::seconds(2);  // between warnings of one kind
constexpr Duration kWatchPeriod = Milliseconds(100);              // whether poses still come

// Of nav2_msgs/ComputeRoute; those of ComputeAndTrackRoute are the same.
std::uint16_t RouteCodeOf(const Error& error) {
  using Code = msg::ComputeRoute;
  if (Is(error, Fault::kFrame) || Is(error, Fault::kOdometry)) return Code::kTfError;
  if (Is(error, Fault::kMap)) return Code::kNoValidGraph;
  if (Is(error, Fault::kOutside) || Is(error, Fault::kIdentifier)) {
    return Code::kIndeterminantNodesOnGraph;
  }
  return Is(error, Fault::kWalledIn) ? Code::kNoValidRoute : Code::kUnknown;
}

msg::Point ToPoint(const Point& at) {
  return {at.x_m, at.y_m, at.z_m};
}

template <class Span>
Span SpanOf(Duration time) {
  const msg::Stamp stamp = msg::ToStamp(time);
  Span span;
  span.sec = stamp.sec;
  span.nanosec = stamp.nanosec;
  return span;
}

}  // namespace

RouteServer::RouteServer(const Dependencies& dependencies, RouteConfig config,
                         std::unique_ptr<Background> background)
    : dependencies_(dependencies),
      config_(std::move(config)),
      graph_file_(config_.graph_file),
      graph_(config_.graph),
      frames_(config_.tf.stale),
      warnings_([this](const std::string& line) { Log(LogLevel::kWarning, line); },
                kQuietTimeOfRoutes),
      background_(std::move(background)),
      endpoints_(dependencies.node, dependencies.name_space) {}

RouteServer::~RouteServer() {
  Permit(false, "the server ends");
}

Result<std::unique_ptr<RouteServer>> RouteServer::Make(const Dependencies& dependencies,
                                                       const RouteConfig& config,
                                                       std::unique_ptr<Background> background) {
  if (config.graph == nullptr) return MakeError(Fault::kMap, "the graph was not read");
  if (!background) background = std::make_unique<ThreadBackground>(dependencies.node.loop());
  std::unique_ptr<RouteServer> server(new RouteServer(dependencies, config, std::move(background)));
  const Result<> opened = server->Open();
  if (!opened) return opened.error();
  return server;
}

Result<> RouteServer::Open() {
  for (const RouteRobot& config : config_.robots) {
    robots_.push_back(std::make_unique<Robot>());
    robots_.back()->config = &config;
    OpenRobot(*robots_.back());
  }
  endpoints_.Serve<msg::DynamicEdges>(
      config_.edges, [this](const auto& request, auto reply) { reply(ChangeEdges(request)); });
  endpoints_.Serve<msg::SetRouteGraph>(config_.set_graph, [this](const auto& request, auto reply) {
    ReadGraph(request.graph_filepath, [reply](bool success) {
      msg::SetRouteGraph::Response response;
      response.success = success;
      reply(response);
    });
  });
  SubscribeFrames(endpoints_, config_.tf, dependencies_.clock, frames_);
  auto& loop = dependencies_.node.loop();
  ticks_ = loop.Every(kQuietTimeOfRoutes, [this, &loop] { warnings_.Tick(loop.Now()); });
  watch_ = loop.Every(kWatchPeriod, [this] { Watch(); });
  Log(LogLevel::kInfo, fmt::format("{} nodes and {} edges of {}", graph_->nodes.size(),
                                   graph_->edges.size(), graph_file_));
  return endpoints_.opened();
}

void RouteServer::OpenRobot(Robot& robot) {
  const RouteRobot& config = *robot.config;
  endpoints_.Subscribe<msg::Odometry>(
      config.odometry, [this, &robot](const auto& odometry) { OnOdometry(robot, odometry); },
      transport::kSensorDataQos);
  const auto accept = [this, &robot](const auto&, transport::ParticipantId) {
    if (!permitted_) {
      Warn(robot.config->name + "state",
           robot.config->name + ": a goal is rejected: " + not_permitted_);
    }
    return permitted_;
  };
  transport::ActionServerOptions options;
  options.stamp = [this] { return dependencies_.clock.Stamp(); };
  transport::ActionHandlers<Compute> computes;
  computes.accept = accept;
  computes.start = [this, &robot](const auto& goal) { OnCompute(robot, goal); };
  computes.cancel = [](auto goal) { goal.Canceled({}); };
  endpoints_.ServeAction<Compute>(config.action, std::move(computes), options);
  transport::ActionHandlers<Track> tracks;
  tracks.accept = accept;
  tracks.start = [this, &robot](const TrackGoal& goal) { OnTrack(robot, goal); };
  tracks.cancel = [this, &robot](TrackGoal goal) {
    Track::Result result;
    if (robot.tracked && robot.tracked->goal.id() == goal.id()) {
      result.execution_duration =
          SpanOf<decltype(result.execution_duration)>(Now() - robot.tracked->begin);
      robot.tracked.reset();
    }
    goal.Canceled(result);
  };
  endpoints_.ServeAction<Track>(config.track, std::move(tracks), std::move(options));
}

void RouteServer::Warn(const std::string& kind, const std::string& what) {
  warnings_.Log(kind, what, dependencies_.node.loop().Now());
}

void RouteServer::OnOdometry(Robot& robot, const msg::Odometry& odometry) {
  auto motion = ToMotion(odometry, config_.frame, frames_, Now());
  if (!motion) {
    return Warn(robot.config->name + "odometry",
                robot.config->name + ": refused: " + motion.error().message);
  }
  robot.motion = motion.value();
  robot.motion_at = Now();
  Follow(robot);
}

void RouteServer::OnTimeJump(const std::string& why) {
  frames_.Forget();
  for (const auto& robot : robots_) {
    robot->motion.reset();
    Drop(*robot, why);
  }
}

void RouteServer::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (permitted) return;
  not_permitted_ = why;
  for (const auto& robot : robots_) Drop(*robot, why);
}

Result<> RouteServer::CheckPlace(const Robot& robot) const {
  if (IsFresh(robot)) return Ok();
  return MakeError(
      Fault::kOdometry,
      fmt::format(
          "the place of the robot is not known: no odometry on {} {}", robot.config->odometry,
          robot.motion ? fmt::format("for {:.1f} s", ToSeconds(Now() - robot.motion_at)) : "yet"));
}

template <class Goal>
Result<RouteServer::Wanted> RouteServer::WantedBy(const Robot& robot, const Goal& goal) const {
  if (!goal.use_poses) {
    const auto from = graph_->NodeOf(goal.start_id), to = graph_->NodeOf(goal.goal_id);
    if (from && to) return Wanted{*from, *to, {}, {}, 0};
    return MakeError(Fault::kIdentifier,
                     from ? fmt::format("goal_id: the graph has no node {}", goal.goal_id)
                          : fmt::format("start_id: the graph has no node {}", goal.start_id));
  }
  auto to = ToPose(goal.goal, config_.frame, "goal");
  if (!to) return to.error();
  Pose from;
  if (goal.use_start) {
    auto start = ToPose(goal.start, config_.frame, "start");
    if (!start) return start.error();
    from = start.value();
  } else if (auto checked = CheckPlace(robot); !checked) {
    return checked.error();
  } else {
    from = robot.motion->pose;
  }
  const auto first =
      NearestNode(*graph_, from.at, config_.near_m, goal.use_start ? "the start" : "the robot at");
  if (!first) return first.error();
  const auto last = NearestNode(*graph_, to.value().at, config_.near_m, "the goal");
  if (!last) return last.error();
  return Wanted{first.value(), last.value(), from.at, to.value().at, to.value().yaw_rad};
}

Result<Route> RouteServer::RouteFor(const Wanted& wanted) const {
  auto route = FindRoute(*graph_, wanted.from, wanted.to, changes_);
  if (!route) return route;
  return WithoutDetours(*graph_, std::move(route).value(), wanted.start, wanted.goal,
                        config_.beside_m, changes_);
}

msg::Header RouteServer::HeaderNow() const {
  msg::Header header;
  header.stamp = dependencies_.clock.Stamp();
  header.frame_id = config_.frame;
  return header;
}

msg::Route RouteServer::ToMessage(const Route& route) const {
  msg::Route message;
  message.header = HeaderNow();
  message.route_cost = static_cast<float>(route.cost);
  for (const std::size_t i : route.nodes) {
    message.nodes.push_back({graph_->nodes[i].id, ToPoint(graph_->nodes[i].at)});
  }
  for (const std::size_t i : route.edges) {
    const GraphEdge& edge = graph_->edges[i];
    message.edges.push_back(
        {edge.id, ToPoint(graph_->nodes[edge.from].at), ToPoint(graph_->nodes[edge.to].at)});
  }
  return message;
}

msg::Path RouteServer::PathOf(const Route& route, double yaw_rad) const {
  return navigation::ToMessage(PathAlong(*graph_, route, config_.step_m, yaw_rad), HeaderNow());
}

void RouteServer::OnCompute(Robot& robot, const transport::ServerGoal<Compute>& goal) {
  // How long a search takes is real time, also where /clock is slower or faster.
  const auto begin = std::chrono::steady_clock::now();
  transport::ServerGoal<Compute> ended = goal;
  ended.Execute();
  Compute::Result result;
  const auto wanted = WantedBy(robot, goal.goal());
  const auto route = wanted ? RouteFor(wanted.value()) : Result<Route>(wanted.error());
  if (!route) {
    result.error_code = RouteCodeOf(route.error());
    result.error_msg = route.error().message;
    ended.Abort(result);
    return Refused(robot, route.error());
  }
  result.route = ToMessage(route.value());
  result.path = PathOf(route.value(), wanted.value().yaw_rad);
  result.planning_time =
      SpanOf<decltype(result.planning_time)>(std::chrono::steady_clock::now() - begin);
  ended.Succeed(result);
  Log(LogLevel::kInfo, fmt::format("{}: a route of {} nodes to node {}, cost {:.2f}",
                                   robot.config->name, route.value().nodes.size(),
                                   graph_->nodes[wanted.value().to].id, route.value().cost));
}

void RouteServer::OnTrack(Robot& robot, const TrackGoal& goal) {
  Drop(robot, "a newer goal has replaced this one");
  TrackGoal begun = goal;
  begun.Execute();
  const auto wanted = WantedBy(robot, goal.goal());
  auto route = wanted ? RouteFor(wanted.value()) : Result<Route>(wanted.error());
  // Also a route between nodes is tracked by the robot's pose.
  if (const auto checked = CheckPlace(robot); route && !checked) route = checked.error();
  if (!route) {
    Track::Result result;
    result.error_code = RouteCodeOf(route.error());
    result.error_msg = route.error().message;
    begun.Abort(result);
    return Refused(robot, route.error());
  }
  robot.tracked.emplace(Tracked{begun,
                                RouteTracker(graph_, std::move(route).value(), config_.track),
                                wanted.value().to, wanted.value().goal, Now()});
  robot.tracked->tracker.Update(robot.motion->pose.at);
  Report(robot, false);
  Follow(robot);
}

void RouteServer::Report(Robot& robot, bool rerouted) {
  const RouteTracker& tracker = robot.tracked->tracker;
  Track::Feedback feedback;
  const auto id_of = [](const auto& all, std::optional<std::size_t> index) {
    return index ? all[*index].id : RouteId{0};
  };
  feedback.last_node_id = id_of(graph_->nodes, tracker.last_node());
  feedback.next_node_id = id_of(graph_->nodes, tracker.next_node());
  feedback.current_edge_id = id_of(graph_->edges, tracker.edge());
  feedback.route = ToMessage(tracker.route());
  feedback.path = PathOf(tracker.route(), robot.motion ? robot.motion->pose.yaw_rad : 0);
  feedback.rerouted = rerouted;
  robot.tracked->goal.PublishFeedback(feedback);
}

void RouteServer::Follow(Robot& robot) {
  if (!robot.tracked) return;
  if (robot.tracked->tracker.Update(robot.motion->pose.at)) Report(robot, false);
  if (!robot.tracked->tracker.done()) return;
  Track::Result result;
  result.execution_duration =
      SpanOf<decltype(result.execution_duration)>(Now() - robot.tracked->begin);
  robot.tracked->goal.Succeed(result);
  robot.tracked.reset();
  Log(LogLevel::kInfo, robot.config->name + ": it is at the end of its route");
}

// A route is not tracked by a pose of before.
void RouteServer::Watch() {
  for (const auto& robot : robots_) {
    if (!robot->tracked) continue;
    if (const auto checked = CheckPlace(*robot); !checked) End(*robot, checked.error());
  }
}

RouteServer::Track::Result RouteServer::Failed(const Tracked& tracked, const Error& error) const {
  Track::Result result;
  result.execution_duration = SpanOf<decltype(result.execution_duration)>(Now() - tracked.begin);
  result.error_code = RouteCodeOf(error);
  result.error_msg = error.message;
  return result;
}

void RouteServer::End(Robot& robot, const Error& error) {
  robot.tracked->goal.Abort(Failed(*robot.tracked, error));
  robot.tracked.reset();
  Refused(robot, error);
}

void RouteServer::Refused(const Robot& robot, const Error& error) {
  Warn(fmt::format("{} refused {}", robot.config->name, error.code),
       fmt::format("{}: no route: {} (error_code {})", robot.config->name,
                   WithCode(error.message, error.code), RouteCodeOf(error)));
}

void RouteServer::Drop(Robot& robot, const std::string& why) {
  if (!robot.tracked) return;
  robot.tracked->goal.Abort(Failed(*robot.tracked, Error{kCodeFailed, why}));
  robot.tracked.reset();
  Log(LogLevel::kInfo, robot.config->name + ": its route is not tracked any more: " + why);
}

msg::DynamicEdges::Response RouteServer::ChangeEdges(const msg::DynamicEdges::Request& request) {
  msg::DynamicEdges::Response response;
  EdgeChanges changes = changes_;
  std::string why;
  const auto each = [this, &why](RouteId id, const auto& change) {
    const auto edge = graph_->EdgeOf(id);
    if (edge) return change(*edge);
    why = fmt::format("the graph has no edge {}", id);
  };
  for (const RouteId id : request.closed_edges) {
    each(id, [&](std::size_t edge) { changes.closed.insert(edge); });
  }
  for (const RouteId id : request.opened_edges) {
    each(id, [&](std::size_t edge) { changes.closed.erase(edge); });
  }
  for (const msg::EdgeCost& cost : request.adjust_edges) {
    each(cost.edgeid, [&](std::size_t edge) { changes.dearer[edge] = cost.cost; });
    if (!(cost.cost >= 0 && std::isfinite(cost.cost))) {
      why = fmt::format("the cost of edge {} is no number from 0 on", cost.edgeid);
    }
  }
  response.success = why.empty();
  if (!why.empty()) {
    Warn("edges", "edges are not changed: " + why);
    return response;
  }
  changes_ = std::move(changes);
  Log(LogLevel::kInfo, fmt::format("{} edges are closed, {} cost more", changes_.closed.size(),
                                   changes_.dearer.size()));
  for (const auto& robot : robots_) {
    if (robot->tracked && robot->tracked->tracker.IsClosed(changes_)) RouteAgain(*robot);
  }
  return response;
}

// From the next node where the robot may go on to it, else from the last one, or where it is.
void RouteServer::RouteAgain(Robot& robot) {
  Tracked& tracked = *robot.tracked;
  const RouteTracker& tracker = tracked.tracker;
  const auto edge = tracker.edge();
  const bool goes_on = !edge || !changes_.closed.contains(*edge);
  Wanted wanted{*(goes_on ? tracker.next_node() : tracker.last_node()), tracked.to, std::nullopt,
                tracked.place, 0};
  const auto route = RouteFor(wanted);
  if (!route) return End(robot, route.error());
  Route next = route.value();
  // The edge on which it is stays part of the route.
  if (goes_on && edge) {
    next.nodes.insert(next.nodes.begin(), *tracker.last_node());
    next.edges.insert(next.edges.begin(), *edge);
    next.cost += CostOf(*graph_, *edge, changes_);
  }
  tracked.tracker = RouteTracker(graph_, std::move(next), config_.track, goes_on && edge ? 1 : 0);
  if (robot.motion) tracked.tracker.Update(robot.motion->pose.at);
  Log(LogLevel::kInfo,
      robot.config->name + ": an edge of its route was closed: it has another one");
  Report(robot, true);
}

void RouteServer::ReadGraph(const std::string& path, std::function<void(bool)> reply) {
  const std::string folder = std::filesystem::path(config_.graph_file).parent_path();
  const std::string file = path.empty() ? graph_file_ : config_toml::Absolute(folder, path);
  background_->Do([this, file, frame = config_.frame, reply = std::move(reply)] {
    const auto read = std::make_shared<Result<RouteGraph>>(ReadGraphFile(file, frame));
    return [this, file, read, reply] {
      if (!*read) {
        Warn("graph", "a graph is not used: " + read->error().message + "; the one before stays");
        return reply(false);
      }
      graph_ = std::make_shared<const RouteGraph>(std::move(*read).value());
      graph_file_ = file;
      changes_ = {};
      Log(LogLevel::kInfo, fmt::format("{} nodes and {} edges of {}", graph_->nodes.size(),
                                       graph_->edges.size(), graph_file_));
      for (const auto& robot : robots_) {
        if (robot->tracked) End(*robot, MakeError(Fault::kMap, "the graph was replaced"));
      }
      reply(true);
    };
  });
}

SelfCheckResult RouteServer::Check() const {
  SelfCheckResult result;
  for (const auto& robot : robots_) {
    result.Add(
        IsFresh(*robot) ? "" : robot->config->name + ": no odometry on " + robot->config->odometry);
  }
  return result;
}

}  // namespace musher::navigation
