#include "musher/modules/motion/tool/square_walk.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace musher::motion::tool {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;
constexpr double kArrivedM = 0.01;    // m
constexpr double kTurnedRad = 0.02;   // rad
constexpr double kLeastSpeed = 0.04;  // m/s: a body does not creep
constexpr double kLeastTurn = 0.08;   // rad/s
constexpr double kHighestTurn = 1.0;  // rad/s
constexpr double kHighestSide = 0.1;  // m/s
constexpr double kGain = 2.5;         // 1/s: feedback gain on the error

// At least `least` in its direction, unless it is zero.
double AtLeast(double value, double least) {
  return std::copysign(std::max(std::abs(value), least), value);
}

std::array<float, 3> Speed(double x, double y, double yaw) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(yaw)};
}

}  // namespace

PlanarPose PlanarPoseOf(const Eigen::Isometry3d& body) {
  const Eigen::Vector3d ahead = body.linear() * Eigen::Vector3d::UnitX();
  return {body.translation().head<2>(), std::atan2(ahead.y(), ahead.x())};
}

double WrapAngle(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

double SquareWalk::Heading(int leg) const {
  return begin_.yaw + leg * kQuarter;
}

std::array<float, 3> SquareWalk::Step(const PlanarPose& pose) {
  if (done()) return {};
  if (!turning_) {
    const Eigen::Rotation2Dd to_leg(-Heading(leg_));
    const Eigen::Vector2d way = to_leg * (pose.at - begin_.at - corner_);
    const double left = side_m_ - way.x();
    const double off = WrapAngle(Heading(leg_) - pose.yaw);
    if (left > kArrivedM) {
      const double ahead = std::clamp(kGain * left, kLeastSpeed, speed_);
      const double side = std::clamp(-kGain * way.y(), -kHighestSide, kHighestSide);
      return Speed(ahead, side, std::clamp(kGain * off, -kHighestTurn, kHighestTurn));
    }
    corner_ += Eigen::Rotation2Dd(Heading(leg_)) * Eigen::Vector2d(side_m_, 0);
    turning_ = true;
  }
  const double off = WrapAngle(Heading(leg_ + 1) - pose.yaw);
  if (std::abs(off) > kTurnedRad) {
    return Speed(0, 0, AtLeast(std::clamp(kGain * off, -kHighestTurn, kHighestTurn), kLeastTurn));
  }
  turning_ = false;
  ++leg_;
  return {};
}

}  // namespace musher::motion::tool
