#include "musher/modules/meilin/servers/move_to_pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "musher/modules/meilin/servers/goal_limit.hpp"

namespace musher::meilin::servers {
namespace {

constexpr Duration kBrakePeriod = Milliseconds(20);

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// `value` with a size of at least `least` and at most `most`.
double Within(double value, double least, double most) {
  return std::copysign(std::clamp(std::abs(value), std::min(least, most), most), value);
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
  Enter(MovePhase::kWaiting, now);
}

void MoveToPose::OnPose(const FieldPose& pose, Time now) {
  if (!std::isfinite(pose.x_m + pose.y_m + pose.yaw_rad)) return;
  pose_ = pose;
  pose_at_ = now;
}

void MoveToPose::Stop(Time now) {
  reached_ = false;
  if (phase_ != MovePhase::kIdle) Enter(MovePhase::kBrake, now);
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

MoveToPose::Step MoveToPose::Update(Time now) {
  Measure();
  switch (phase_) {
    case MovePhase::kIdle:
      return {std::nullopt, std::nullopt, true};
    case MovePhase::kWaiting:
      return Wait(now);
    case MovePhase::kBrake:
      break;
    default: {
      const std::string blind = Blind(now);
      if (!blind.empty()) return Fail("Pose lost: " + blind, now);
      return phase_ == MovePhase::kYaw ? Turn(now) : Drive(now);
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
