#include "musher/modules/world/body/robot_body.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSinkMps = 0.5;  // with an empty battery
constexpr double kLandedM = 1e-6;

// At most so long.
Vector2d Limited(const Vector2d& vector, double most) {
  const double length = vector.norm();
  return length > most ? Vector2d(vector * (most / length)) : vector;
}

double Towards(double from, double to, double most) {
  return from + std::clamp(to - from, -most, most);
}

}  // namespace

RobotBody::RobotBody(const RobotSpec& spec, std::uint64_t seed)
    : limits_(spec.limits),
      wind_(spec.wind),
      kind_(spec.kind),
      command_timeout_(spec.command_timeout),
      random_(seed),
      position_m_(spec.start_m),
      yaw_rad_(spec.start_yaw_rad),
      airborne_(spec.kind == RobotKind::kFlyer && spec.start_m.z() > kLandedM) {}

std::optional<std::string> RobotBody::Take(const BodyVelocity& command, Duration now) {
  if (!command.linear_m_s.allFinite() || !std::isfinite(command.turn_rad_s)) {
    return "a velocity that is not a number is refused";
  }
  command_ = command;
  commanded_at_ = now;
  commanded_ = true;
  return std::nullopt;
}

void RobotBody::PutDown(const Vector3d& position_m, double yaw_rad) {
  position_m_ = position_m;
  yaw_rad_ = std::remainder(yaw_rad, 2 * M_PI);
  velocity_ = {};
  commanded_ = false;
  airborne_ = false;
}

BodyVelocity RobotBody::Target(bool battery_empty, Duration now) const {
  const bool flies = kind_ == RobotKind::kFlyer;
  if (battery_empty) return {{0, 0, flies ? -kSinkMps : 0}, 0};
  if (!commanded_ || now - commanded_at_ > command_timeout_) return {};
  BodyVelocity target = command_;
  if (kind_ == RobotKind::kDifferential) target.linear_m_s.y() = 0;
  target.linear_m_s.head<2>() = Limited(target.linear_m_s.head<2>(), limits_.speed_m_s);
  const double climb = flies ? limits_.climb_m_s : 0;
  target.linear_m_s.z() = std::clamp(target.linear_m_s.z(), -climb, climb);
  target.turn_rad_s = std::clamp(target.turn_rad_s, -limits_.turn_rad_s, limits_.turn_rad_s);
  return target;
}

void RobotBody::Approach(const BodyVelocity& target, double seconds) {
  const double most = limits_.acceleration_m_s2 * seconds;
  const Vector2d now = velocity_.linear_m_s.head<2>();
  velocity_.linear_m_s.head<2>() = now + Limited(target.linear_m_s.head<2>() - now, most);
  velocity_.linear_m_s.z() = Towards(velocity_.linear_m_s.z(), target.linear_m_s.z(), most);
  velocity_.turn_rad_s =
      Towards(velocity_.turn_rad_s, target.turn_rad_s, limits_.turn_acceleration_rad_s2 * seconds);
}

// An Ornstein-Uhlenbeck process: it forgets its value within a gust, and keeps its deviation.
void RobotBody::Blow(double seconds) {
  const double keep = std::exp(-seconds / wind_.gust_s);
  const double fresh = wind_.drift_m_s * std::sqrt(1 - keep * keep);
  for (const int axis : {0, 1}) {
    drift_m_s_[axis] = keep * drift_m_s_[axis] + fresh * random_.Normal();
  }
}

void RobotBody::Step(const RobotPlace& place, bool battery_empty, Duration now, Duration dt) {
  const double seconds = ToSeconds(dt);
  const bool flies = kind_ == RobotKind::kFlyer;
  Approach(Target(battery_empty, now), seconds);
  if (wind_.drift_m_s > 0) Blow(seconds);
  const double floor_m = flies ? place.floor_m(position_m_) : 0;
  if (flies && position_m_.z() <= floor_m + kLandedM && velocity_.linear_m_s.z() <= 0) {
    velocity_ = {};
  }
  airborne_ = flies && (position_m_.z() > floor_m + kLandedM || velocity_.linear_m_s.z() > 0);
  yaw_rad_ = std::remainder(yaw_rad_ + velocity_.turn_rad_s * seconds, 2 * M_PI);

  Vector3d moved_m = velocity_.linear_m_s * seconds;
  moved_m.head<2>() = Rotation2Dd(yaw_rad_) * Vector2d(moved_m.head<2>());
  if (flies) moved_m.z() = std::max(moved_m.z(), floor_m - position_m_.z());
  drifted_m_s_ = airborne_ ? drift_m_s_ : Vector2d(0, 0);
  Vector3d blown_m = moved_m;
  blown_m.head<2>() += drifted_m_s_ * seconds;
  stopped_by_.clear();
  if (blown_m.isZero(0)) return;
  if (!place.obstacle(position_m_, position_m_ + blown_m)) {
    position_m_ += blown_m;
    return;
  }
  drifted_m_s_.setZero();  // what is in the way shields it from the wind
  if (const auto obstacle = place.obstacle(position_m_, position_m_ + moved_m)) {
    stopped_by_ = *obstacle;
    velocity_.linear_m_s.setZero();
    return;
  }
  position_m_ += moved_m;
}

BodyVelocity RobotBody::velocity() const {
  BodyVelocity velocity = velocity_;
  velocity.linear_m_s.head<2>() += Rotation2Dd(-yaw_rad_) * drifted_m_s_;
  return velocity;
}

bool RobotBody::moving() const {
  constexpr double kStill = 0.01;
  return airborne_ || velocity_.linear_m_s.norm() > kStill ||
         std::abs(velocity_.turn_rad_s) > kStill;
}

}  // namespace musher::world
