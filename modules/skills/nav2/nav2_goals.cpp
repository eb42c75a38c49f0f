#include "musher/modules/skills/nav2/nav2_goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/base/words.hpp"
#include "musher/messages/nav2_msgs/follow_waypoints.hpp"
#include "musher/messages/nav2_msgs/navigate_through_poses.hpp"
#include "musher/messages/nav2_msgs/navigate_to_pose.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/modules/skills/skills/travel.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/place_text.hpp"

namespace musher::skills {
namespace {

constexpr Duration kFeedbackPeriod = Milliseconds(200);
constexpr std::uint32_t kMostLoops = 1'000'000;

struct Places {
  std::vector<msg::PoseStamped> poses;
  std::size_t first = 0;
  std::uint32_t loops = 0;  // after the first one
  bool goes_on = false;     // after a pose that was not reached
};

Places PlacesOf(const msg::NavigateToPose::Goal& goal) {
  return {.poses = {goal.pose}};
}
Places PlacesOf(const msg::NavigateThroughPoses::Goal& goal) {
  return {.poses = goal.poses};
}
Places PlacesOf(const msg::FollowWaypoints::Goal& goal) {
  return {goal.poses, goal.goal_index, std::min(goal.number_of_loops, kMostLoops), true};
}

// The place to which a robot is sent; the orientation may be of any length above 0.
Result<navigation::Pose> PlaceOf(const msg::PoseStamped& stamped) {
  const std::string& frame = stamped.header.frame_id;
  if (!frame.empty() && frame != kMapFrame) {
    return MakeError(navigation::Fault::kFrame, "the frame of the goal is '" + frame.substr(0, 40) +
                                                    "', expected '" + kMapFrame + "'");
  }
  const auto pose = ToPose(stamped.pose);
  if (pose) return *pose;
  return Error{kCodeParametersInvalid,
               "the goal has a number that is not finite, or an orientation without a length"};
}

Result<std::vector<navigation::Pose>> CheckedPlaces(const Places& places) {
  if (places.first >= places.poses.size()) {
    return Error{kCodeParametersInvalid, places.poses.empty()
                                             ? "the goal has no poses"
                                             : fmt::format("goal_index is {}, of {}", places.first,
                                                           Counted(places.poses.size(), "pose"))};
  }
  std::vector<navigation::Pose> checked;
  for (const msg::PoseStamped& stamped : places.poses) {
    const auto place = PlaceOf(stamped);
    if (!place) return place.error();
    checked.push_back(place.value());
  }
  return checked;
}

msg::TimeSpan ToDuration(Duration time) {
  const msg::Stamp stamp = msg::ToStamp(time);
  return {stamp.sec, stamp.nanosec};
}

}  // namespace

// A goal of one of the actions, while it is executed.
class Nav2Goals::Mission {
 public:
  Mission(std::string requested_by, Places places, std::vector<navigation::Pose> poses, Time now)
      : requested_by(std::move(requested_by)),
        places(std::move(places)),
        poses(std::move(poses)),
        at(this->places.first),
        begun(now) {}
  virtual ~Mission() = default;

  virtual void Feedback(const Robot& robot, const skill::Run& run, Time now) = 0;
  // `code`: 0, or why it has not succeeded.
  virtual void Succeed() = 0;
  virtual void Abort(const std::string& why) = 0;
  virtual void Canceled() = 0;

  // To the next pose; false: that was the last one.
  bool Next() {
    if (++at < poses.size()) return true;
    if (loops_done >= places.loops) return false;
    ++loops_done;
    at = 0;
    return true;
  }

  const std::string requested_by;
  const Places places;
  const std::vector<navigation::Pose> poses;
  std::size_t at = 0;
  std::uint64_t run = 0;  // the number of the run to that pose
  std::uint32_t loops_done = 0;
  const Time begun;
  std::vector<std::size_t> missed;
  std::string why_missed;  // the first one
  std::optional<Time> reported_at;
  bool canceled = false;
};

template <class Action>
class Nav2Goals::MissionOf final : public Mission {
 public:
  MissionOf(transport::ServerGoal<Action> goal, std::string requested_by, Places places,
            std::vector<navigation::Pose> poses, Time now)
      : Mission(std::move(requested_by), std::move(places), std::move(poses), now),
        goal_(std::move(goal)) {}

  const transport::GoalId& id() const { return goal_.id(); }

  void Feedback(const Robot& robot, const skill::Run& run, Time now) override {
    typename Action::Feedback feedback;
    if constexpr (std::is_same_v<Action, msg::FollowWaypoints>) {
      feedback.current_waypoint = static_cast<std::uint32_t>(at);
    } else {
      const skill::Values& details = run.feedback().details;
      feedback.current_pose = ToMessage(robot.pose().value_or(navigation::Pose{}), {});
      feedback.navigation_time = ToDuration(now - begun);
      feedback.estimated_time_remaining =
          ToDuration(FromSeconds(std::clamp(details.Get("estimated_time", 0.0), 0.0, 1e6)));
      feedback.distance_remaining = static_cast<float>(details.Get("distance_to_goal", 0.0));
      feedback.number_of_recoveries = static_cast<std::int16_t>(std::min(run.replans(), 32767));
      if constexpr (std::is_same_v<Action, msg::NavigateThroughPoses>) {
        feedback.number_of_poses_remaining = static_cast<std::int16_t>(poses.size() - at);
      }
    }
    goal_.PublishFeedback(feedback);
  }
  void Succeed() override { goal_.Succeed({}); }
  void Canceled() override { goal_.Canceled(ResultOf(0, "")); }
  void Abort(const std::string& why) override { goal_.Abort(ResultOf(Action::kUnknown, why)); }

 private:
  typename Action::Result ResultOf(std::uint16_t code, const std::string& why) const {
    typename Action::Result result;
    result.error_code = code;
    result.error_msg = why;
    if constexpr (std::is_same_v<Action, msg::FollowWaypoints>) {
      for (const std::size_t index : missed) {
        result.missed_waypoints.push_back({static_cast<std::uint32_t>(index), places.poses[index],
                                           msg::NavigateToPose::kUnknown});
      }
    }
    return result;
  }

  transport::ServerGoal<Action> goal_;
};

// A goal of the topic: its client gets no reply.
class Nav2Goals::TopicMission final : public Mission {
 public:
  TopicMission(const Nav2Goals& goals, const msg::PoseStamped& stamped,
               const navigation::Pose& place, Time now)
      : Mission(goals.goal_pose_, {.poses = {stamped}}, {place}, now),
        log_(goals.context_.log),
        goal_(fmt::format("the goal {} on {}",
                          navigation::PlaceText(place.at, !goals.context_.robot.flies()),
                          goals.goal_pose_)) {}

  void Feedback(const Robot& /*robot*/, const skill::Run& /*run*/, Time /*now*/) override {}
  void Succeed() override { log_(LogLevel::kInfo, goal_ + " is reached"); }
  void Canceled() override { Abort("cancelled"); }
  void Abort(const std::string& why) override {
    log_(LogLevel::kWarning, goal_ + " is not reached: " + why);
  }

 private:
  const std::function<void(LogLevel, const std::string&)> log_;
  const std::string goal_;
};

std::string Nav2Goals::SkillFor(const std::vector<std::string>& names) {
  for (const char* skill : {"navigate_to", "nav_2d", "nav_3d"}) {
    if (std::ranges::find(names, skill) != names.end()) return skill;
  }
  return "";
}

Nav2Goals::Nav2Goals(Context context, const InterfaceNames& names, transport::Endpoints& endpoints)
    : context_(std::move(context)),
      skill_(SkillFor(context_.manager.Names())),
      node_(endpoints.node()),
      clock_(endpoints.clock()),
      goal_pose_(names.goal_pose) {
  if (skill_.empty()) return;
  Serve<msg::NavigateToPose>(names.navigate_to_pose, endpoints);
  Serve<msg::NavigateThroughPoses>(names.navigate_through_poses, endpoints);
  Serve<msg::FollowWaypoints>(names.follow_waypoints, endpoints);
  if (goal_pose_.empty()) return;
  endpoints.Subscribe<msg::PoseStamped>(goal_pose_,
                                        [this](const msg::PoseStamped& goal) { OnGoalPose(goal); });
}

Nav2Goals::~Nav2Goals() {
  End(false, "the skills end");
}

template <class Action>
void Nav2Goals::Serve(const std::string& name, transport::Endpoints& endpoints) {
  if (name.empty()) return;
  transport::ActionHandlers<Action> handlers;
  handlers.start = [this](transport::ServerGoal<Action> goal) { Start(std::move(goal)); };
  handlers.cancel = [this](transport::ServerGoal<Action> goal) {
    const auto* own = dynamic_cast<const MissionOf<Action>*>(mission_.get());
    if (own == nullptr || own->id() != goal.id()) {
      goal.Canceled({});  // before it was started
      return;
    }
    mission_->canceled = true;
    Update();  // its run may have ended since the last step, and one of another client begun
    if (!mission_) return;
    static_cast<void>(context_.manager.Cancel(skill_, "by its client"));
    if (!context_.may_start()) {  // no step would see it
      static_cast<void>(context_.manager.CancelNow(skill_, "by its client"));
      Update();
    }
  };
  endpoints.ServeAction<Action>(name, std::move(handlers));
}

template <class Action>
void Nav2Goals::Start(transport::ServerGoal<Action> goal) {
  const auto refuse = [&goal](std::uint16_t code, const std::string& why) {
    typename Action::Result result;
    result.error_code = code;
    result.error_msg = why;
    goal.Abort(result);
  };
  Places places = PlacesOf(goal.goal());
  auto poses = CheckedPlaces(places);
  if (!poses) {
    std::uint16_t code = Action::kUnknown;
    if constexpr (requires { Action::kTfError; }) {
      if (Is(poses.error(), navigation::Fault::kFrame)) code = Action::kTfError;
    }
    return refuse(code, poses.error().message);
  }
  if (const Result<> may =
          MayBegin(places.goes_on ? std::vector<navigation::Pose>{} : poses.value());
      !may) {
    return refuse(Action::kUnknown, may.error().message);
  }
  Replace();
  goal.Execute();
  std::string by = transport::NameOf(node_, goal.caller());
  mission_ = std::make_unique<MissionOf<Action>>(std::move(goal), std::move(by), std::move(places),
                                                 std::move(poses).value(), clock_.Now());
  if (const Result<> driven = Drive(); !driven) End(false, driven.error().message);
}

void Nav2Goals::Replace() {
  Update();  // its run may have ended since the last step, and one of another client begun
  if (!mission_) return;
  static_cast<void>(context_.manager.CancelNow(skill_, "by a newer goal"));
  End(false, "a newer goal has replaced this one");
}

// Before a newer goal replaces the present one.
Result<> Nav2Goals::MayBegin(const std::vector<navigation::Pose>& places) const {
  if (Result<> may = context_.may_start(); !may) return may;
  const Robot& robot = context_.robot;
  for (const navigation::Pose& place : places) {
    if (Result<> may = CheckAltitude(robot, "the goal", place.at.z_m); !may) return may;
  }
  return Ok();
}

void Nav2Goals::OnGoalPose(const msg::PoseStamped& goal) {
  auto place = PlaceOf(goal);
  Result<> may = place ? Ok() : Result<>(place.error());
  const auto here = context_.robot.flies() ? context_.robot.pose() : std::nullopt;
  if (may && here && place.value().at.z_m == 0) {  // a button for a goal gives no height
    may = CheckInTheAir(context_.robot, here->at.z_m);
    place.value().at.z_m = here->at.z_m;
  }
  if (may) may = MayBegin({place.value()});
  if (!may) {
    return context_.log(LogLevel::kWarning,
                        "a goal on " + goal_pose_ + " is refused: " + may.error().message);
  }
  Replace();
  mission_ = std::make_unique<TopicMission>(*this, goal, place.value(), clock_.Now());
  if (const Result<> driven = Drive(); !driven) End(false, driven.error().message);
}

Result<> Nav2Goals::Drive() {
  const navigation::Pose& to = mission_->poses[mission_->at];
  const double half_rad = to.yaw_rad / 2;
  Result<> started = context_.manager.Start(
      skill_,
      {{"goal_pos", skill::Numbers{to.at.x_m, to.at.y_m, to.at.z_m}},
       {"goal_quat_wxyz", skill::Numbers{std::cos(half_rad), 0, 0, std::sin(half_rad)}}},
      {"", mission_->requested_by});
  if (started) mission_->run = context_.manager.Find(skill_)->number();
  return started;
}

void Nav2Goals::Update() {
  if (!mission_) return;
  const skill::Run* run = context_.manager.Find(skill_);
  if (run == nullptr) return End(false, "its skill was reset");
  if (run->number() != mission_->run) {  // its end is not known: it may have arrived
    return End(false, "its run has ended, and another client has started " + skill_);
  }
  if (run->ended()) return OnEndOfRun(*run);
  const Time now = clock_.Now();
  if (mission_->reported_at && now - *mission_->reported_at < kFeedbackPeriod) return;
  mission_->reported_at = now;
  mission_->Feedback(context_.robot, *run, now);
}

void Nav2Goals::OnEndOfRun(const skill::Run& run) {
  const skill::Feedback& feedback = run.feedback();
  // Also if the run has failed or completed before its cancellation was done.
  if (mission_->canceled) return End(false, ToText(feedback));
  if (feedback.status == skill::Status::kCancelled) return End(false, ToText(feedback));
  if (feedback.status == skill::Status::kFailed) {
    if (!mission_->places.goes_on) return End(false, feedback.message);
    if (mission_->missed.empty()) mission_->why_missed = feedback.message;
    mission_->missed.push_back(mission_->at);
  }
  if (mission_->Next()) {
    Result<> driven = context_.may_start();
    if (driven) driven = Drive();
    return driven ? void() : End(false, driven.error().message);
  }
  const std::size_t missed = mission_->missed.size();
  if (missed == 0) return End(true, "");
  End(false, fmt::format("{} not reached; the first one: {}", Counted(missed, "way-point"),
                         mission_->why_missed));
}

void Nav2Goals::End(bool success, const std::string& why) {
  const auto mission = std::exchange(mission_, nullptr);
  if (!mission) return;
  if (success) return mission->Succeed();
  if (mission->canceled) return mission->Canceled();
  mission->Abort(why);
}

}  // namespace musher::skills
