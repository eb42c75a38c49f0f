#include "musher/modules/skills/robot/flight_hold.hpp"

namespace musher::skills {
namespace {

constexpr double kBrakedMS = 0.15;
constexpr Duration kLongestBraking = std::chrono::seconds(1);  // a wind does not brake
constexpr double kSlowBelowM = 0.6;
constexpr double kStillM = 0.02;
constexpr Duration kStands = std::chrono::seconds(2);  // on the ground, or a table

}  // namespace

void FlightHold::Use() {
  armed_ = true;
  landed_ = false;
  braking_ = still_ = {};
  place_.reset();
  hold_.Reset();
}

void FlightHold::Land() {
  armed_ = false;
  landed_ = true;
}

void FlightHold::SetBatteryLow(bool low) {
  if (low && !low_ && !landed_ && !armed_) Use();
  still_ = {};
  low_ = low;
}

std::optional<navigation::Velocity> FlightHold::Command(const std::optional<navigation::Pose>& pose,
                                                        double speed_m_s, Duration step) {
  if (!armed_) return std::nullopt;
  if (!pose || !navigation::IsFinite(*pose)) {
    hold_.Reset();
    return navigation::Velocity{0, 0, low_ ? -kLastDescentMps : 0, 0};
  }
  if (!place_ && pose->at.z_m < kInTheAirM) return std::nullopt;
  braking_ += step;
  if (!place_ && speed_m_s > kBrakedMS && braking_ < kLongestBraking) return navigation::Velocity{};
  if (!place_) {
    place_ = pose;
    lowest_m_ = pose->at.z_m;
  }
  if (low_) place_->at.z_m = pose->at.z_m;
  if (navigation::Distance(pose->at, place_->at) > kLostM) {
    armed_ = false;
    return std::nullopt;
  }
  if (low_) return Descend(*pose, step);
  return hold_.Command(*place_, *pose, PositionHold::SecondsOf(step));
}

std::optional<navigation::Velocity> FlightHold::Descend(const navigation::Pose& pose,
                                                        Duration step) {
  const bool lower = pose.at.z_m < lowest_m_ - kStillM;
  if (lower) lowest_m_ = pose.at.z_m;
  still_ = lower ? Duration{} : still_ + step;
  if (still_ >= kStands) {
    Land();
    return std::nullopt;
  }
  navigation::Velocity command = hold_.Command(*place_, pose, PositionHold::SecondsOf(step));
  command.z_m_s = pose.at.z_m < kSlowBelowM ? -kLastDescentMps : -kDescentMps;
  return command;
}

}  // namespace musher::skills
