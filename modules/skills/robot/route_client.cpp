#include "musher/modules/skills/robot/route_client.hpp"

#include <utility>

#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/navigation/navigation_fault.hpp"

namespace musher::skills {
namespace {

constexpr Duration kRouteAnswerTime = std::chrono::seconds(3);  // of the server, to a goal
constexpr Duration kRouteCancelTime = std::chrono::seconds(1);

using transport::GoalEnd;

// Why there is no route, from the code of the server's result, with its words.
Error RouteError(std::uint16_t error_code, const std::string& words) {
  using Code = msg::ComputeRoute;
  using navigation::Fault;
  constexpr std::size_t kLongest = 200;
  const std::string said = words.empty()
                               ? "the route server has failed with " + std::to_string(error_code)
                               : words.substr(0, kLongest);
  switch (error_code) {
    case Code::kTfError:
      return navigation::MakeError(Fault::kOdometry, said);
    case Code::kNoValidGraph:
      return navigation::MakeError(Fault::kMap, said);
    case Code::kIndeterminantNodesOnGraph:
      return navigation::MakeError(Fault::kOutside, said);
    case Code::kTimeout:
      return navigation::MakeError(Fault::kTimeLimit, said);
    case Code::kNoValidRoute:
      return navigation::MakeError(Fault::kWalledIn, said);
    default:
      return {kCodeStateInvalid, said};
  }
}

// Of a goal that has not succeeded.
template <class Outcome>
Error RouteErrorOf(const Outcome& outcome) {
  if (outcome.end == GoalEnd::kAborted) {
    return RouteError(outcome.result.error_code, outcome.result.error_msg);
  }
  if (outcome.end == GoalEnd::kCanceled) return {kCodeFailed, "the route was cancelled"};
  return {outcome.end == GoalEnd::kRejected ? kCodeStateInvalid : kCodeNetError,
          "the route server: " + outcome.reason};
}

Result<navigation::Pose> OnlyOfTheMap(const std::string& frame) {
  if (frame.empty() || frame == kMapFrame) return navigation::Pose{};
  return navigation::MakeError(navigation::Fault::kFrame, "its frame is not that of the map");
}

Result<PlannedRoute> RouteOf(const msg::Route& route, const msg::Path& path) {
  const auto failed = [](const Error& error) {
    return Error{error.code, "the server's route is not used: " + error.message};
  };
  auto converted = ToPath(path, OnlyOfTheMap);
  if (!converted) return failed(converted.error());
  if (const auto frame = OnlyOfTheMap(route.header.frame_id); !frame) return failed(frame.error());
  PlannedRoute planned{std::move(converted).value(), {}, {}, route.route_cost};
  for (const msg::RouteNode& node : route.nodes) {
    const navigation::Point at{node.position.x, node.position.y, node.position.z};
    if (!navigation::IsFinite(at)) return failed({kCodeFailed, "a node is not finite"});
    planned.nodes.push_back({node.nodeid, at});
  }
  for (const msg::RouteEdge& edge : route.edges) planned.edges.push_back(edge.edgeid);
  return planned;
}

}  // namespace

struct RouteClient::TrackGoal {
  transport::GoalId id{};
  skill::Source<bool> source;
  skill::Future<bool> end = source.future();
  RouteReport report;
  bool accepted = false;
  bool dropped = false;
  std::shared_ptr<Tracks*> tracks;

  // A goal that is not accepted yet is cancelled once it is: its server does not know it before.
  void CancelIfDropped() {
    if (!dropped || !accepted || end.done() || *tracks == nullptr) return;
    (*tracks)->Cancel(id, kRouteCancelTime, [](const auto&) {});
  }
};

class RouteClient::GoalRoute : public TrackedRoute {
 public:
  explicit GoalRoute(std::shared_ptr<TrackGoal> goal) : goal_(std::move(goal)) {}
  ~GoalRoute() override {
    goal_->dropped = true;
    goal_->CancelIfDropped();
  }

  const RouteReport& report() const override { return goal_->report; }
  skill::Future<bool> end() const override { return goal_->end; }

 private:
  const std::shared_ptr<TrackGoal> goal_;
};

RouteClient::RouteClient(transport::Endpoints& endpoints, const std::string& route,
                         const std::string& track)
    : stamp_([&clock = endpoints.clock()] { return clock.Stamp(); }),
      computes_(endpoints.OpenActionClient<msg::ComputeRoute>(route)),
      tracks_(
          std::make_shared<Tracks*>(endpoints.OpenActionClient<msg::ComputeAndTrackRoute>(track))) {
}

template <class Goal>
Goal RouteClient::ToMessage(const RouteGoal& goal) const {
  const msg::Stamp stamp = stamp_();
  Goal message;
  message.use_poses = goal.by_poses;
  message.start_id = goal.start_id;
  message.goal_id = goal.goal_id;
  message.use_start = goal.start.has_value();
  if (goal.start) message.start = skills::ToMessage(*goal.start, stamp);
  if (goal.by_poses) message.goal = skills::ToMessage(goal.goal, stamp);
  return message;
}

skill::Future<PlannedRoute> RouteClient::ComputeRoute(const RouteGoal& goal) {
  const auto source = std::make_shared<skill::Source<PlannedRoute>>();
  skill::Future<PlannedRoute> future = source->future();
  if (computes_ == nullptr) {
    source->Fail("there is no route server");
    return future;
  }
  transport::GoalEvents<msg::ComputeRoute> events;
  events.on_end = [source](const auto& outcome) {
    source->Set(outcome.end == GoalEnd::kSucceeded
                    ? RouteOf(outcome.result.route, outcome.result.path)
                    : Result<PlannedRoute>(RouteErrorOf(outcome)));
  };
  computes_->SendGoal(ToMessage<msg::ComputeRoute::Goal>(goal), kRouteAnswerTime,
                      std::move(events));
  return future;
}

std::unique_ptr<TrackedRoute> RouteClient::TrackRoute(const RouteGoal& goal) {
  const auto tracked = std::make_shared<TrackGoal>();
  tracked->tracks = tracks_;
  if (*tracks_ == nullptr) {
    tracked->source.Fail("there is no route server");
    return std::make_unique<GoalRoute>(tracked);
  }
  transport::GoalEvents<msg::ComputeAndTrackRoute> events;
  events.on_accepted = [tracked] {
    tracked->accepted = true;
    tracked->CancelIfDropped();
  };
  events.on_feedback = [tracked](const auto& feedback) {
    auto route = RouteOf(feedback.route, feedback.path);
    if (!route) return;
    RouteReport& report = tracked->report;
    report.last_node = feedback.last_node_id;
    report.next_node = feedback.next_node_id;
    report.edge = feedback.current_edge_id;
    report.route = std::move(route).value();
    report.rerouted = feedback.rerouted;
    ++report.count;
  };
  events.on_end = [tracked](const auto& outcome) {
    tracked->source.Set(outcome.end == GoalEnd::kSucceeded ? Result<bool>(true)
                                                           : Result<bool>(RouteErrorOf(outcome)));
  };
  tracked->id = (*tracks_)->SendGoal(ToMessage<msg::ComputeAndTrackRoute::Goal>(goal),
                                     kRouteAnswerTime, std::move(events));
  std::erase_if(tracked_, [](const auto& route) { return route.expired(); });
  tracked_.push_back(tracked);
  return std::make_unique<GoalRoute>(tracked);
}

void RouteClient::CancelTracked() {
  if (*tracks_ == nullptr) return;
  (*tracks_)->CancelAll(kRouteCancelTime, [](const auto&) {});
  for (const auto& route : tracked_) {
    if (const auto goal = route.lock()) goal->dropped = goal->dropped || !goal->accepted;
  }
}

}  // namespace musher::skills
