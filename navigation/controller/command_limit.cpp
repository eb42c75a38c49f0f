#include "musher/navigation/controller/command_limit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace musher::navigation {
namespace {

constexpr double kLongestGapS = 0.1;  // a pause of the updates lets no command jump

Velocity Difference(const Velocity& a, const Velocity& b) {
  return {a.x_m_s - b.x_m_s, a.y_m_s - b.y_m_s, a.z_m_s - b.z_m_s, a.yaw_rad_s - b.yaw_rad_s};
}

double Dot(const Velocity& a, const Velocity& b) {
  return a.x_m_s * b.x_m_s + a.y_m_s * b.y_m_s + a.z_m_s * b.z_m_s;
}

Velocity Scaled(const Velocity& velocity, double share) {
  return {velocity.x_m_s * share, velocity.y_m_s * share, velocity.z_m_s * share,
          velocity.yaw_rad_s * share};
}

// The largest share of `velocity`, up to 1, that is at most `most` away from `last`. Nullopt: none.
std::optional<double> ShareWithin(const Velocity& velocity, const Velocity& last, double most) {
  const double square = Dot(velocity, velocity), along = Dot(velocity, last);
  const double inside = along * along - square * (Dot(last, last) - most * most);
  if (square <= 0 || inside < 0) return std::nullopt;
  const double share = (along + std::sqrt(inside)) / square;
  return share >= 0 ? std::optional(std::min(share, 1.0)) : std::nullopt;
}

// A rate up to `most` faster than the last one, or slower than that: a turn may end at once.
double YawWithin(double wanted, double last, double most) {
  return std::clamp(wanted, std::min(last, 0.0) - most, std::max(last, 0.0) + most);
}

}  // namespace

void CommandLimit::Begin(Time now) {
  at_ = now;
  wanted_ = sent_ = {};
}

Velocity CommandLimit::BeforeGate(const Velocity& wanted, double yaw_rad, Time now, bool brakes) {
  step_s_ = std::clamp(ToSeconds(now - at_), 0.0, kLongestGapS);
  at_ = std::max(at_, now);
  Velocity command = InBodyFrame(wanted, -FrameYaw(yaw_rad));
  const Velocity change = Difference(command, wanted_);
  const double size = Speed(change), most = limits_.acceleration_m_s2 * step_s_;
  const bool slower = brakes && Speed(command) <= Speed(wanted_);
  const double share = size > most && !slower ? most / size : 1;
  const double most_yaw = limits_.yaw_rad_s2 * step_s_;
  wanted_ = {wanted_.x_m_s + share * change.x_m_s, wanted_.y_m_s + share * change.y_m_s,
             wanted_.z_m_s + share * change.z_m_s,
             wanted_.yaw_rad_s + std::clamp(change.yaw_rad_s, -most_yaw, most_yaw)};
  return InBodyFrame(wanted_, FrameYaw(yaw_rad));
}

Velocity CommandLimit::AfterGate(const Velocity& passed, double yaw_rad) {
  const Velocity command = InBodyFrame(passed, -FrameYaw(yaw_rad));
  const double speed_m_s = Speed(command), last_m_s = Speed(sent_);
  const double most = limits_.acceleration_m_s2 * step_s_;
  double share = 1;
  if (speed_m_s > last_m_s && Speed(Difference(command, sent_)) > most + 1e-6) {
    share = ShareWithin(command, sent_, most).value_or(last_m_s / speed_m_s);
  }
  const double yaw_rad_s =
      YawWithin(share * command.yaw_rad_s, sent_.yaw_rad_s, limits_.yaw_rad_s2 * step_s_);
  sent_ = Scaled(command, share);
  Velocity sent = Scaled(passed, share);
  sent_.yaw_rad_s = sent.yaw_rad_s = yaw_rad_s;
  return sent;
}

bool CommandLimit::IsAtRest() const {
  return Speed(sent_) <= limits_.acceleration_m_s2 * step_s_ &&
         std::abs(sent_.yaw_rad_s) <= limits_.yaw_rad_s2 * step_s_;
}

}  // namespace musher::navigation
