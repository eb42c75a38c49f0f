#include "musher/modules/meilin/servers/move_to_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "musher/modules/meilin/servers/goal_limit.hpp"

namespace musher::meilin::servers {
namespace {

constexpr Duration kBrakePeriod = Milliseconds(20);
// In a climb the body waits at the step until its wheels have reached their heights.
constexpr Duration kClimbStuck = std::chrono::seconds(10);

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// `value` with a size of at least `least` and at most `most`.
double Within(double value, double least, double most) {
  return std::copysign(std::clamp(std::abs(value), std::min(least, most), most), value);
}

navigation::GuardRules GuardOf(const MoveSettings& settings, bool climbing) {
  navigation::GuardRules rules;
  rules.speed_m_s = settings.max_m_s;
  rules.yaw_rad_s = std::max(settings.max_yaw_rad_s, settings.max_xy_yaw_rad_s);
  // On a platform of 1.2 m: as soon as without a pose.
  rules.frozen = std::min(rules.frozen, settings.pose_stale);
  if (climbing) rules.stuck = rules.frozen = kClimbStuck;
  return rules;
}

}  // namespace

double WrappedYaw(double yaw_rad) {
  return std::remainder(yaw_rad, 2 * std::numbers::pi);
}

const char* MovePhaseName(MovePhase phase) {
  switch (phase) {
    case MovePhase::kWaiting:
      return "waiting_for_pose";
    case MovePhase::kYaw:
      return "yaw";
    case MovePhase::kXy:
      return "xy";
    case MovePhase::kBrake:
      return "brake";
    case MovePhase::kIdle:
      break;
  }
  return "idle";
}

MoveToPose::MoveToPose(const MoveSettings& settings)
    : settings_(settings),
      guard_(GuardOf(settings, false)),
      yaw_(settings.yaw, settings.integral_limit),
      xy_yaw_(settings.xy_yaw, settings.integral_limit),
      x_(settings.x, settings.integral_limit),
      y_(settings.y, settings.integral_limit) {}

void MoveToPose::Enter(MovePhase phase, Time now) {
  phase_ = phase;
  since_ = now;
  last_.reset();
  for (Pid* pid : {&yaw_, &xy_yaw_, &x_, &y_}) pid->Reset();
}

void MoveToPose::Begin(const FieldPose& target, Time now) {
  target_ = {target.x_m, target.y_m, WrappedYaw(target.yaw_rad)};
  reached_ = false;
  feedback_ = {};
  fastest_.reset();
  late_ = {};
  guard_.Restart();
  fault_.clear();
  Enter(MovePhase::kWaiting, now);
}

void MoveToPose::OnPose(const FieldPose& pose, Time now, Duration stamp) {
  if (!std::isfinite(pose.x_m + pose.y_m + pose.yaw_rad)) return;
  pose_ = pose;
  pose_at_ = now;
  if (stamp != Duration{}) {
    const Duration offset = now.time_since_epoch() - stamp;
    fastest_ = std::min(fastest_.value_or(offset), offset);
    late_ = offset - *fastest_;
  }
  const auto fault = guard_.OnPose({{pose.x_m, pose.y_m}, pose.yaw_rad}, stamp, now);
  if (fault && Drives() && fault_.empty()) fault_ = fault->message;
}

void MoveToPose::OnClimbing(bool climbing) {
  if (climbing == climbing_) return;
  climbing_ = climbing;
  guard_.Restart(GuardOf(settings_, climbing));
}

void MoveToPose::ForgetPose() {
  pose_.reset();
  guard_.Forget();
}

void MoveToPose::Stop(Time now) {
  reached_ = false;
  Enter(MovePhase::kBrake, now);
}

std::string MoveToPose::CancelText() const {
  switch (phase_) {
    case MovePhase::kWaiting:
      return "Goal canceled while waiting for relocation pose";
    case MovePhase::kYaw:
      return "Goal canceled during yaw phase";
    default:
      return "Goal canceled during xy phase";
  }
}

std::string MoveToPose::Blind(Time now) const {
  if (!pose_) return "no pose yet";
  if (now - pose_at_ <= settings_.pose_stale) return "";
  return fmt::format("no pose for {:.1f} s", ToSeconds(now - pose_at_));
}

Duration MoveToPose::UpdatePeriod() const {
  return phase_ == MovePhase::kBrake ? std::min(kBrakePeriod, settings_.period) : settings_.period;
}

double MoveToPose::SecondsSinceLast(Time now) {
  const double dt_s = last_ ? ToSeconds(now - *last_) : 0;
  last_ = now;
  return std::max(0.0, dt_s);
}

void MoveToPose::Measure() {
  feedback_.phase = phase_;
  feedback_.target = target_;
  if (!pose_) return;
  feedback_.current = *pose_;
  feedback_.yaw_error_rad = WrappedYaw(target_.yaw_rad - pose_->yaw_rad);
  feedback_.distance_m = std::hypot(target_.x_m - pose_->x_m, target_.y_m - pose_->y_m);
}

MoveToPose::Step MoveToPose::Send(const BodyVelocity& command) {
  feedback_.command = command;
  return {command, std::nullopt, false};
}

MoveToPose::Step MoveToPose::Fail(const std::string& why, Time now) {
  Stop(now);
  Step step = Send({});
  step.end = MoveEnd{false, why};
  return step;
}

// Why its pose is not where the body is now; empty: it is.
std::string MoveToPose::WhyNotTrue(Time now) const {
  if (const std::string blind = Blind(now); !blind.empty()) return "Pose lost: " + blind;
  if (late_ <= settings_.pose_stale) return fault_;
  return fmt::format("Pose lost: it comes {:.1f} s late", ToSeconds(late_));
}

MoveToPose::Step MoveToPose::Guarded(const Step& step, Time now) {
  if (step.end || !Drives()) return step;
  const BodyVelocity& sent = *step.command;
  const auto fault = guard_.OnCommand({sent.x_m_s, sent.y_m_s, 0, sent.yaw_rad_s}, now);
  // Where no pose comes it is lost, and soon named so.
  const bool comes = now - pose_at_ <= settings_.pose_stale / 2;
  return fault && comes ? Fail(fault->message, now) : step;
}

MoveToPose::Step MoveToPose::Update(Time now) {
  Measure();
  switch (phase_) {
    case MovePhase::kIdle:
      return {std::nullopt, std::nullopt, true};
    case MovePhase::kWaiting:
      return Guarded(Wait(now), now);
    case MovePhase::kBrake:
      break;
    default: {
      const std::string why = WhyNotTrue(now);
      if (!why.empty()) return Fail(why, now);
      return Guarded(phase_ == MovePhase::kYaw ? Turn(now) : Drive(now), now);
    }
  }
  Step step = Send({});
  if (now - since_ < settings_.brake_time) return step;
  phase_ = MovePhase::kIdle;
  step.idle = true;
  if (reached_) step.end = MoveEnd{true, "Goal reached"};
  reached_ = false;
  return step;
}

MoveToPose::Step MoveToPose::Wait(Time now) {
  if (Blind(now).empty()) {
    Enter(MovePhase::kYaw, now);
    Measure();
    return Turn(now);
  }
  if (now - since_ < settings_.pose_wait) return Send({});
  return Fail("Timed out waiting for relocation pose", now);
}

double MoveToPose::TurnRate(double dt_s) {
  const double error = feedback_.yaw_error_rad;
  if (std::abs(error) <= Radians(settings_.yaw_tolerance_deg)) {
    yaw_.Update(error, dt_s);
    return 0;
  }
  const double rate = yaw_.Update(error, dt_s);
  return Within(rate, settings_.min_yaw_rad_s, settings_.max_yaw_rad_s);
}

MoveToPose::Step MoveToPose::Turn(Time now) {
  if (std::abs(feedback_.yaw_error_rad) <= Radians(settings_.yaw_tolerance_deg)) {
    Enter(MovePhase::kXy, now);
    Measure();
    return Drive(now);
  }
  if (now - since_ >= settings_.yaw_limit) return Fail("Yaw phase timed out", now);
  return Send({0, 0, TurnRate(SecondsSinceLast(now))});
}

MoveToPose::Step MoveToPose::Drive(Time now) {
  const bool there = feedback_.distance_m <= settings_.xy_tolerance_m;
  const bool turned = std::abs(feedback_.yaw_error_rad) <= Radians(settings_.yaw_tolerance_deg);
  if (there && turned) {
    Stop(now);
    reached_ = true;
    return Send({});
  }
  if (now - since_ >= settings_.xy_limit) return Fail("XY phase timed out", now);
  const double dt_s = SecondsSinceLast(now);
  const double vx = x_.Update(target_.x_m - pose_->x_m, dt_s);
  const double vy = y_.Update(target_.y_m - pose_->y_m, dt_s);
  // At its place only the yaw is left, with the least rate that moves the body.
  if (there) return Send({0, 0, TurnRate(dt_s)});
  double most = settings_.max_m_s;
  if (climbing_ && settings_.climb_m_s > 0) most = std::min(most, settings_.climb_m_s);
  if (settings_.brake_m_s2 > 0) {
    most = std::min(most, std::sqrt(2 * settings_.brake_m_s2 * feedback_.distance_m));
  }
  const double speed = std::hypot(vx, vy);
  const double wanted = Within(speed, settings_.min_m_s, std::max(most, settings_.min_m_s));
  const double scale = speed > 0 ? wanted / speed : 0;
  const double c = std::cos(pose_->yaw_rad);
  const double s = std::sin(pose_->yaw_rad);
  const double turn = xy_yaw_.Update(feedback_.yaw_error_rad, dt_s);
  return Send({scale * (c * vx + s * vy), scale * (-s * vx + c * vy),
               Within(turn, 0, settings_.max_xy_yaw_rad_s)});
}

}  // namespace musher::meilin::servers
