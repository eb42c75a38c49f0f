#include "musher/modules/skills/robot/navigator.hpp"

#include <algorithm>
#include <utility>

#include "musher/modules/skills/robot/conversions.hpp"

namespace musher::skills {
namespace {

constexpr Duration kAnswerTime = std::chrono::seconds(3);  // of a server, to a goal
constexpr Duration kCancelTime = std::chrono::seconds(1);  // then the cancellation is repeated
constexpr int kStatusWithinS = 3;  // of the connection: the latched status of a controller

using transport::GoalEnd;

// A server that was lost, or rejects the goal because it is not Active yet: it may take the next
// one.
template <class Outcome>
Error Unreached(const std::string& server, const Outcome& outcome) {
  return Error{outcome.end == GoalEnd::kRejected ? kCodeStateInvalid : kCodeNetError,
               server + ": " + outcome.reason};
}

Result<navigation::Path> PathOf(const transport::GoalOutcome<msg::ComputePathToPose>& outcome,
                                const navigation::Pose& goal,
                                const std::optional<navigation::Pose>& start,
                                const PlaceOfFrame& in_map) {
  if (outcome.end == GoalEnd::kSucceeded) {
    auto path = ToPath(outcome.result.path, in_map);
    if (path) return path;
    return Error{path.error().code, "the planner's path is not used: " + path.error().message};
  }
  if (outcome.end == GoalEnd::kAborted) {
    return PlannerError(outcome.result.error_code, goal, start, outcome.result.error_msg);
  }
  if (outcome.end == GoalEnd::kCanceled) return Error{kCodeFailed, "the planning was cancelled"};
  return Unreached("the planner", outcome);
}

Result<bool> ArrivalOf(const transport::GoalOutcome<msg::FollowPath>& outcome, bool cancelled) {
  if (outcome.end == GoalEnd::kSucceeded) return true;
  if (cancelled || outcome.end == GoalEnd::kCanceled) return false;
  if (outcome.end == GoalEnd::kAborted) {
    return ControllerError(outcome.result.error_code, outcome.result.error_msg);
  }
  return Unreached("the controller", outcome);
}

}  // namespace

struct Navigator::Request {
  transport::GoalId id{};
  skill::Source<navigation::Path> source;
  bool waits_for_reply = false;  // of the cancellation
  bool ended = false;
};

struct Navigator::DriveGoal {
  Navigator* navigator = nullptr;  // null: nothing is left to do, or the navigator is destroyed
  transport::GoalId id{};
  skill::Source<bool> source;
  skill::Future<bool> end = source.future();
  std::optional<double> distance_m;
  bool accepted = false;
  bool ended = false;
  bool cancelled = false;
  bool waits_for_reply = false;  // of the cancellation
};

// Outlives its navigator, whose end fails the future.
class Navigator::GoalDrive : public Drive {
 public:
  explicit GoalDrive(std::shared_ptr<DriveGoal> goal) : goal_(std::move(goal)) {}
  ~GoalDrive() override { GoalDrive::Cancel(); }

  std::optional<double> distance_to_goal_m() const override { return goal_->distance_m; }
  void Cancel() override {
    if (goal_->navigator != nullptr) goal_->navigator->CancelGoal(goal_);
  }
  skill::Future<bool> end() const override { return goal_->end; }

 private:
  const std::shared_ptr<DriveGoal> goal_;
};

Navigator::Navigator(transport::EventLoop& loop, Planner* planner, Controller* controller,
                     std::function<msg::Stamp()> stamp, PlaceOfFrame in_map)
    : planner_(planner),
      controller_(controller),
      stamp_(std::move(stamp)),
      in_map_(std::move(in_map)),
      repeats_(loop.Every(kCancelTime, [this] { RepeatCancellations(); })) {}

skill::Future<navigation::Path> Navigator::ComputePath(
    const navigation::Pose& goal, const std::optional<navigation::Pose>& start) {
  auto request = std::make_shared<Request>();
  skill::Future<navigation::Path> future = request->source.future();
  if (planner_ == nullptr) {
    request->source.Fail("there is no planner");
    return future;
  }
  const msg::Stamp stamp = stamp_();
  msg::ComputePathToPose::Goal message;
  message.goal = ToMessage(goal, stamp);
  message.use_start = start.has_value();
  if (start) message.start = ToMessage(*start, stamp);
  transport::GoalEvents<msg::ComputePathToPose> events;
  events.on_end = [request, goal, start, in_map = in_map_](const auto& outcome) {
    request->ended = true;
    request->source.Set(PathOf(outcome, goal, start, in_map));
  };
  request->id = planner_->SendGoal(message, kAnswerTime, std::move(events));
  requests_.push_back(std::move(request));
  return future;
}

std::unique_ptr<Drive> Navigator::FollowPath(const navigation::Path& path) {
  auto goal = std::make_shared<DriveGoal>();
  if (controller_ == nullptr) {
    goal->source.Fail("there is no controller");
    return std::make_unique<GoalDrive>(std::move(goal));
  }
  msg::FollowPath::Goal message;
  message.path = ToMessage(path, stamp_());
  transport::GoalEvents<msg::FollowPath> events;
  events.on_accepted = [goal] {
    goal->accepted = true;
    if (goal->cancelled && goal->navigator != nullptr) goal->navigator->CancelGoal(goal);
  };
  events.on_feedback = [goal](const msg::FollowPath::Feedback& feedback) {
    goal->distance_m = feedback.distance_to_goal;
  };
  events.on_end = [goal](const auto& outcome) {
    goal->ended = true;
    goal->source.Set(ArrivalOf(outcome, goal->cancelled));
    // A controller that was out of reach, or hung, may drive on.
    const bool may_drive = outcome.end == GoalEnd::kLost && goal->accepted;
    if (may_drive && goal->navigator != nullptr) return goal->navigator->CancelGoal(goal);
    goal->navigator = nullptr;
  };
  goal->id = controller_->SendGoal(message, kAnswerTime, std::move(events));
  goal->navigator = this;
  drives_.push_back(goal);
  return std::make_unique<GoalDrive>(std::move(goal));
}

Navigator::~Navigator() {
  for (const auto& goal : drives_) {
    goal->navigator = nullptr;
    goal->source.Set(Error{kCodeNetError, "the robot's topics are closed"});
  }
}

// A goal that is not accepted yet is cancelled once it is: its server does not know it before.
// Again and again until a server replies, also the controller's next process, which does not know
// it: one that is out of reach may drive on.
void Navigator::CancelGoal(const std::shared_ptr<DriveGoal>& goal) {
  goal->cancelled = true;
  if (!goal->accepted || goal->waits_for_reply) return;
  goal->waits_for_reply = true;
  controller_->Cancel(goal->id, kCancelTime, [goal](const auto& reply) {
    goal->waits_for_reply = false;
    if (!reply && goal->navigator != nullptr) return goal->navigator->CancelGoal(goal);
    if (goal->ended) goal->navigator = nullptr;
  });
}

void Navigator::CancelRequest(const std::shared_ptr<Request>& request) {
  if (request->waits_for_reply) return;
  request->waits_for_reply = true;
  planner_->Cancel(request->id, kCancelTime,
                   [request](const auto& /*reply*/) { request->waits_for_reply = false; });
}

void Navigator::Update() {
  std::erase_if(requests_, [](const auto& request) { return request->ended; });
  std::erase_if(drives_, [](const auto& goal) { return goal->navigator == nullptr; });
  for (const auto& request : requests_) {
    if (!request->source.wanted()) CancelRequest(request);
  }
  for (const auto& goal : drives_) {
    if (goal->cancelled) CancelGoal(goal);
  }
}

bool Navigator::Drives() const {
  return std::any_of(drives_.begin(), drives_.end(),
                     [](const auto& goal) { return goal->navigator != nullptr && !goal->ended; });
}

bool Navigator::ControllerDrives() const {
  return std::ranges::any_of(active_, [](const auto& of) { return !of.second.empty(); });
}

void Navigator::CancelEarlierDrives() {
  for (const auto& goal : drives_) CancelGoal(goal);
  awaits_status_ = reached_s_ < kStatusWithinS;
  for (const auto& [controller, active] : active_) CancelEarlier(active);
}

void Navigator::TakeStatus(const msg::GoalStatusArray& goals, transport::EndpointId controller) {
  const auto [known, first] = active_.try_emplace(controller);
  GoalIds& active = known->second;
  active.clear();
  for (const msg::GoalStatus& goal : goals.status_list) {
    const bool is_active = goal.status == msg::GoalStatus::kStatusAccepted ||
                           goal.status == msg::GoalStatus::kStatusExecuting ||
                           goal.status == msg::GoalStatus::kStatusCanceling;
    const transport::GoalId& id = goal.goal_info.goal_id.uuid;
    if (is_active) {
      active.insert(id);
    } else {
      earlier_.erase(id);
    }
  }
  if (first && awaits_status_) CancelEarlier(active);
}

void Navigator::CancelEarlier(const GoalIds& active) {
  for (const transport::GoalId& id : active) {
    const bool own = std::ranges::any_of(drives_, [&](const auto& goal) { return goal->id == id; });
    if (!own && earlier_.insert(id).second) RequestCancel(id);
  }
}

// What the reply says is in the status as well, and the status also says what comes of it.
void Navigator::RequestCancel(const transport::GoalId& id) {
  if (controller_ != nullptr) controller_->Cancel(id, kCancelTime, [](const auto& /*reply*/) {});
}

// Once a second. The drives of a controller that is lost are not active, and stay in earlier_: they
// are cancelled when its status comes again.
void Navigator::RepeatCancellations() {
  reached_s_ = HasController() ? std::min(reached_s_ + 1, kStatusWithinS) : 0;
  if (reached_s_ == kStatusWithinS) awaits_status_ = false;
  for (const auto& [controller, active] : active_) {
    for (const transport::GoalId& id : active) {
      if (earlier_.contains(id)) RequestCancel(id);
    }
  }
}

void Navigator::CancelAll() {
  Update();
  for (const auto& request : requests_) {
    request->source.Fail("the planning was cancelled");
    CancelRequest(request);
  }
  for (const auto& goal : drives_) CancelGoal(goal);
}

}  // namespace musher::skills
