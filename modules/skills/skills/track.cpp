#include "musher/modules/skills/skills/track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace musher::skills {
namespace {

using skill::Next;
using skill::Tick;
using Kind = TravelStep::Kind;

constexpr double kToleranceM = 0.3;
constexpr Duration kUnseen = std::chrono::seconds(1);
// New paths replace a drive that waits at an obstacle before it says so.
constexpr const char* kStands = "the robot makes no progress along its path, as at an obstacle";
constexpr Duration kStandsLong = std::chrono::seconds(3);

}  // namespace

void Track::Declare(skill::Table& table) {
  initializing_ = table.State("INITIALIZING");
  executing_ = table.State("EXECUTING");
  stopping_ = table.State("STOPPING");
  table.To(initializing_, executing_, "the servers are reachable, the target is seen");
  table.To(executing_, stopping_, "the duration is over, or cancel");
  table.To(initializing_, stopping_, "cancel");
  table.To(stopping_, skill::kSucceeded, "the robot stands after the duration");
  table.To(stopping_, skill::kCancelled, "the robot stands");
  table.To(initializing_, skill::kFailed, "failed");
  table.To(executing_, skill::kFailed, "the target is lost");
  table.Limit({.run = skill::kNoLimit});
  table.MonotoneProgress();
  table.Does("Follows a target and keeps a distance from it");
  table.Uses(kBase);
  table.Takes("target_topic", std::string("/target_0/odom"), "nav_msgs/Odometry of the target");
  table.Takes("track_period", std::int64_t{10}, "poses of the target from plan to plan");
  table.Takes("distance", 1.5, "m, kept from the target");
  table.Takes("lost_limit", 10.0, "s without the target or a path to it, then it fails");
  table.Takes("duration", 0.0, "s, 0: until it is cancelled");
  table.RefusesParameter("cancel", "to cancel the skill, cancel its goal");
}

std::optional<std::string> Track::WhyRefused(const skill::Values& parameters) const {
  const auto period = parameters.Get<std::int64_t>("track_period", 0);
  if (parameters.Text("target_topic").empty()) return "target_topic is empty; expected a topic";
  if (period < 1) return fmt::format("track_period is {}; expected 1 or more", period);
  for (const char* name : {"distance", "lost_limit", "duration"}) {
    const double number = parameters.Number(name);
    const bool zero = std::string_view(name) == "duration";
    if (number > 0 || (zero && number == 0)) continue;
    return fmt::format("{} is {:g}; expected {}", name, number,
                       zero ? "0 or more seconds" : "more than 0");
  }
  return std::nullopt;
}

Next Track::Step(Tick& tick) {
  if (tick.state == stopping_) {
    return Stop(tick, fmt::format("Tracked for {:.1f} s", tick.parameters.Number("duration")));
  }
  if (const auto why = WhyRefused(tick.parameters)) return Next::Fail(*why);
  if (const Result<> may = CheckAfterPause(); !may) return Next::Fail(may.error().message);
  DoNotGiveWay();
  return tick.state == initializing_ ? Initialize(tick) : Execute(tick);
}

Next Track::Initialize(Tick& tick) {
  target_ = robot_.PoseOf(tick.parameters.Text("target_topic"));
  if (target_ && travel_.Reach().kind == Kind::kDone) return Next::To(executing_);
  const std::string why = WhyNotReady(tick);
  if (ToSeconds(tick.elapsed) >= tick.parameters.Number("lost_limit")) return Next::Fail(why);
  tick.Report(5, ToSeconds(tick.elapsed) < 1 ? "Waiting for the target" : "Waiting: " + why);
  return Next::Stay();
}

std::string Track::WhyNotReady(const Tick& tick) const {
  const TravelStep servers = travel_.Reach();
  if (servers.kind != Kind::kDone) return servers.why;
  return "Target not seen: " + robot_.WhyNoPoseOf(tick.parameters.Text("target_topic"));
}

Next Track::OnLimit(Tick& tick) {
  return Next::Fail(WhyNotReady(tick));
}

Next Track::Execute(Tick& tick) {
  const double duration_s = tick.parameters.Number("duration");
  if (duration_s > 0 && ToSeconds(tick.elapsed) >= duration_s) return Complete(tick);
  const std::string topic = tick.parameters.Text("target_topic");
  const auto seen = robot_.PoseOf(topic);
  unseen_ = seen ? Duration{} : unseen_ + tick.step;
  if (seen && IsFinite(*seen)) target_ = seen;
  const std::uint64_t came = robot_.PosesOf(topic);
  poses_ += static_cast<std::int64_t>(came >= counted_ ? came - counted_ : came);
  counted_ = came;
  const double limit_s = tick.parameters.Number("lost_limit");
  if (ToSeconds(unseen_) >= limit_s) {
    return Next::Fail(
        fmt::format("Target lost: {} for {:.1f} s", robot_.WhyNoPoseOf(topic), limit_s));
  }
  PlanAndDrive(tick);
  if (ToSeconds(standstill_.time()) >= limit_s) {
    return Next::Fail(fmt::format("No path to the target for {:.1f} s: {}", limit_s,
                                  trouble_.empty() ? kStands : trouble_));
  }
  Report(tick);
  return Next::Stay();
}

double Track::DistanceTo(const navigation::Pose& target) const {
  const auto pose = robot_.pose().value_or(navigation::Pose());
  return std::hypot(target.at.x_m - pose.at.x_m, target.at.y_m - pose.at.y_m);
}

std::optional<navigation::Pose> Track::GoalFor(const navigation::Pose& target,
                                               double distance_m) const {
  const auto pose = robot_.pose();
  if (!pose) return std::nullopt;
  const double apart_m = DistanceTo(target);
  if (apart_m >= distance_m / 2 && apart_m <= distance_m + kToleranceM) return std::nullopt;
  // Where they are at one place, it backs away in the direction behind it.
  const double away_rad =
      apart_m > 1e-3 ? std::atan2(pose->at.y_m - target.at.y_m, pose->at.x_m - target.at.x_m)
                     : pose->yaw_rad + M_PI;
  const navigation::Point at{target.at.x_m + distance_m * std::cos(away_rad),
                             target.at.y_m + distance_m * std::sin(away_rad), pose->at.z_m};
  return navigation::Pose{at, navigation::Wrapped(away_rad + M_PI)};
}

void Track::PlanAndDrive(const Tick& tick) {
  const auto wanted =
      target_ ? GoalFor(*target_, tick.parameters.Number("distance")) : std::nullopt;
  if (!wanted && robot_.pose()) {
    // Near enough: it stands, or ends its drive to a place that is right.
    const bool right = goal_ && target_ &&
                       std::abs(navigation::Distance(
                                    goal_->at, {target_->at.x_m, target_->at.y_m, goal_->at.z_m}) -
                                tick.parameters.Number("distance")) <= kToleranceM;
    if (travel_.driving() && right) {
      Note(travel_.Drive(tick.step));
      HasPath();
      return;
    }
    if (travel_.driving() || travel_.planning()) travel_.GiveUp();
    goal_.reset();
    HasPath();
    return;
  }
  const auto period = tick.parameters.Get<std::int64_t>("track_period", 1);
  const bool begins = !travel_.driving() && !travel_.planning();
  if (wanted && !travel_.planning() && (begins || poses_ >= period)) {
    goal_ = wanted;
    poses_ = 0;
    Plan({});
  } else if (travel_.planning()) {
    Plan(tick.step);
  }
  if (travel_.driving()) {
    const TravelStep step = travel_.Drive(tick.step);
    Note(step);
    if (step.kind == Kind::kDone) return HasPath();
  }
  standstill_.Note(robot_.pose(), tick.step);
  if (standstill_.time() == Duration{}) trouble_.clear();
}

void Track::HasPath() {
  standstill_.Restart();
  trouble_.clear();
}

void Track::Plan(Duration step) {
  const TravelStep planned = travel_.Plan(*goal_, std::nullopt, step);
  if (planned.kind == Kind::kDone) travel_.Begin(travel_.planned());
  Note(planned);
}

void Track::Note(const TravelStep& step) {
  if (step.kind != Kind::kPending && step.kind != Kind::kDone) trouble_ = step.why;
}

void Track::Report(Tick& tick) const {
  const double duration_s = tick.parameters.Number("duration");
  const double share = duration_s > 0 ? ToSeconds(tick.elapsed) / duration_s : 0;
  const double apart_m = target_ ? DistanceTo(*target_) : 0;
  std::string message = "Tracking... (" + LengthText(apart_m) + " m)";
  if (unseen_ >= kUnseen) {
    message = fmt::format("Target lost ({:.1f}s)", ToSeconds(unseen_));
  } else if (standstill_.time() >= (trouble_.empty() ? kStandsLong : kUnseen)) {
    message = fmt::format("No path to the target ({:.1f}s): {}", ToSeconds(standstill_.time()),
                          trouble_.empty() ? kStands : trouble_);
  }
  tick.Report(10 + 85 * share, message);
  tick.Detail("target_distance", apart_m);
  if (travel_.driving()) travel_.AddDetails(tick);
}

}  // namespace musher::skills
