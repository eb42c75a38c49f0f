#include "musher/modules/skills/robot/position_hold.hpp"

#include <algorithm>

namespace musher::skills {
namespace {

constexpr double kGainPerS = 2;
constexpr double kIntegralGainPerS2 = 1;
// Farther away it flies there.
constexpr double kIntegralRangeM = 0.5;
// An error that shrinks faster is no wind: an integral of it would carry the flyer past.
constexpr double kSteadyMps = 0.1;

double Learned(double wind_mps, double error_m, double last_error_m, double step_s) {
  if (std::abs(error_m) > kIntegralRangeM) return wind_mps;
  if (std::abs(error_m - last_error_m) > kSteadyMps * step_s) return wind_mps;
  return std::clamp(wind_mps + kIntegralGainPerS2 * error_m * step_s, -PositionHold::kSpeedMps,
                    PositionHold::kSpeedMps);
}

double Limited(double value, double most) {
  return std::clamp(value, -most, most);
}

}  // namespace

navigation::Velocity PositionHold::Command(const navigation::Pose& place,
                                           const navigation::Pose& now, double step_s) {
  const navigation::Point error{place.at.x_m - now.at.x_m, place.at.y_m - now.at.y_m,
                                place.at.z_m - now.at.z_m};
  const navigation::Point last = last_error_.value_or(error);
  wind_.x_m = Learned(wind_.x_m, error.x_m, last.x_m, step_s);
  wind_.y_m = Learned(wind_.y_m, error.y_m, last.y_m, step_s);
  wind_.z_m = Learned(wind_.z_m, error.z_m, last.z_m, step_s);
  last_error_ = error;
  navigation::Velocity velocity{
      kGainPerS * error.x_m + wind_.x_m, kGainPerS * error.y_m + wind_.y_m,
      Limited(kGainPerS * error.z_m + wind_.z_m, kSpeedMps),
      Limited(kGainPerS * navigation::Wrapped(place.yaw_rad - now.yaw_rad), kYawRateRadS)};
  const double speed_mps = std::hypot(velocity.x_m_s, velocity.y_m_s);
  if (speed_mps > kSpeedMps) {
    velocity.x_m_s *= kSpeedMps / speed_mps;
    velocity.y_m_s *= kSpeedMps / speed_mps;
  }
  return navigation::InBodyFrame(velocity, now.yaw_rad);
}

}  // namespace musher::skills
