#include "musher/navigation/gate/motion_guard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr Duration kJumpWithin = Milliseconds(500);  // also a jump in several steps
constexpr double kFasterThanLimit = 1.5;             // a body may be so much faster than its limit
constexpr double kMovedM = 0.05;                     // it moves
constexpr double kMovedRad = 0.1;
constexpr double kCommandedM = 0.3;  // enough to see whether it moves
constexpr double kCommandedRad = 0.6;
constexpr Duration kOdometryStale = Milliseconds(500);
constexpr double kRestsAfterS = 1.5;
constexpr double kPushedM = 0.3;
constexpr double kPushedRad = 0.8;
constexpr double kLongestGuardS = 0.2;
constexpr double kMostHeldUpS = 10;  // of messages

double Turned(const Pose& from, const Pose& to) {
  return std::abs(Wrapped(to.yaw_rad - from.yaw_rad));
}

}  // namespace

bool MotionGuard::Commanded::IsEnough() const {
  return way_m >= kCommandedM || turn_rad >= kCommandedRad;
}

void MotionGuard::Commanded::Add(const Velocity& velocity, double seconds) {
  way_m += Speed(velocity) * seconds;
  turn_rad += std::abs(velocity.yaw_rad_s) * seconds;
  if (velocity != Velocity{}) driven_s += seconds;
}

void MotionGuard::Restart() {
  anchor_.reset();
  since_anchor_ = since_change_ = {};
  sent_ = {};
  sent_at_.reset();
  resting_since_.reset();
  rest_.reset();
}

void MotionGuard::Forget() {
  Restart();
  seen_.clear();
}

std::optional<Error> MotionGuard::Jump(const Seen& from, const Seen& to) const {
  const double here_s = ToSeconds(to.at - from.at);
  const double there_s = std::min(ToSeconds(to.taken - from.taken), kMostHeldUpS);
  const double passed_s = std::max({here_s, there_s, 0.0});
  const double moved_m = Distance(from.pose.at, to.pose.at);
  if (moved_m > rules_.jump_m + kFasterThanLimit * rules_.speed_m_s * passed_s) {
    return MakeError(Fault::kJump, fmt::format("the pose has jumped by {:.3g} m in {:.2f} s, which "
                                               "no body with {:.1f} m/s can do",
                                               moved_m, passed_s, rules_.speed_m_s));
  }
  const double turned_rad = Turned(from.pose, to.pose);
  if (turned_rad <= rules_.jump_rad + kFasterThanLimit * rules_.yaw_rad_s * passed_s)
    return std::nullopt;
  return MakeError(Fault::kJump, fmt::format("the direction has jumped by {:.1f} rad in {:.2f} s, "
                                             "which no body with {:.1f} rad/s can do",
                                             turned_rad, passed_s, rules_.yaw_rad_s));
}

std::optional<Error> MotionGuard::OnPose(const Pose& pose, Duration stamp, Time now) {
  if (!IsFinite(pose)) return std::nullopt;
  taken_ = age_.Take(stamp, now).value_or(taken_.value_or(now));
  const Seen here{pose, *taken_, now};
  std::optional<Error> fault;
  if (!seen_.empty()) fault = Jump(seen_.back(), here);
  if (!seen_.empty() && !fault) fault = Jump(seen_.front(), here);
  if (!seen_.empty() && !(pose == seen_.back().pose)) since_change_ = {};
  if (fault) seen_.clear();
  seen_.push_back(here);
  while (seen_.front().at < now - kJumpWithin) seen_.pop_front();
  if (!anchor_) anchor_ = pose;
  if (Distance(pose.at, anchor_->at) >= kMovedM || Turned(pose, *anchor_) >= kMovedRad) {
    anchor_ = pose;
    since_anchor_ = {};
  }
  return fault;
}

std::optional<Error> MotionGuard::Stuck(double seconds, Time now) {
  // Without odometry it is not known.
  if (seen_.empty() || now - seen_.back().at > kOdometryStale) return std::nullopt;
  since_anchor_.Add(sent_, seconds);
  since_change_.Add(sent_, seconds);
  const bool stands =
      since_change_.IsEnough() && since_change_.driven_s >= ToSeconds(rules_.frozen);
  const bool stuck = since_anchor_.IsEnough() && since_anchor_.driven_s >= ToSeconds(rules_.stuck);
  if (!stands && !stuck) return std::nullopt;
  const Commanded& commanded = stands ? since_change_ : since_anchor_;
  return MakeError(
      Fault::kStuck,
      fmt::format(
          "commanded {:.2f} m and {:.2f} rad in {:.1f} s, but its odometry {}: it is stuck, "
          "its wheels slip, or its odometry stands",
          commanded.way_m, commanded.turn_rad, commanded.driven_s,
          stands ? "does not change at all" : "shows no motion"));
}

std::optional<Error> MotionGuard::Pushed(Time now) {
  if (rules_.drifts || seen_.empty()) return std::nullopt;
  const Pose& pose = seen_.back().pose;
  if (sent_ != Velocity{}) {
    resting_since_.reset();
    rest_.reset();
    return std::nullopt;
  }
  if (!resting_since_) resting_since_ = now;
  if (ToSeconds(now - *resting_since_) < kRestsAfterS) return std::nullopt;
  if (!rest_) rest_ = pose;
  const double moved_m = Distance(pose.at, rest_->at), turned_rad = Turned(pose, *rest_);
  if (moved_m < kPushedM && turned_rad < kPushedRad) return std::nullopt;
  return MakeError(Fault::kPushed,
                   fmt::format("it has moved by {:.2f} m and {:.2f} rad without a command: it is "
                               "pushed or carried",
                               moved_m, turned_rad));
}

std::optional<Error> MotionGuard::OnCommand(const Velocity& sent, Time now) {
  const double passed_s =
      sent_at_ ? std::clamp(ToSeconds(now - *sent_at_), 0.0, kLongestGuardS) : 0;
  sent_at_ = now;
  auto fault = Stuck(passed_s, now);
  sent_ = sent;
  if (!fault) fault = Pushed(now);
  return fault;
}

}  // namespace musher::navigation
