#include "musher/modules/skills/robot/flight_hold.hpp"

#include <limits>

namespace musher::skills {
namespace {

constexpr double kBrakedMS = 0.15;
constexpr Duration kLongestBraking = std::chrono::seconds(1);  // a wind does not brake
constexpr double kSlowBelowM = 0.6;
constexpr double kStillM = 0.02;
constexpr Duration kStands = std::chrono::seconds(2);
// A height that stands is the ground's below it; above, it may be an estimate that has stopped, or
// an updraught.
constexpr double kGroundToleranceM = 0.3;
constexpr double kSurelyInTheAirM = 0.3;

}  // namespace

void FlightHold::Use() {
  armed_ = true;
  landed_ = arms_ = stands_ = false;
  braking_ = still_ = {};
  place_.reset();
  hold_.Reset();
}

void FlightHold::Land() {
  armed_ = arms_ = false;
  landed_ = true;
}

void FlightHold::SetBatteryLow(bool low) {
  if (low == low_) return;  // a repeated report does not begin the descent again
  low_ = low;
  arms_ = low && !landed_ && !armed_;
  still_ = {};
  lowest_m_ = std::numeric_limits<double>::infinity();
}

void FlightHold::NoteCharging() {
  if (StandsHigh()) Land();
}

void FlightHold::NoteStopped() {
  still_ = {};
}

bool FlightHold::StandsHigh() const {
  return armed_ && low_ && still_ >= kStands;
}

std::optional<navigation::Velocity> FlightHold::Command(const std::optional<navigation::Pose>& pose,
                                                        double speed_m_s, Duration step) {
  const bool known = pose && navigation::IsFinite(*pose);
  if (known && arms_) {  // where it is found decides: one that is lifted later is in a hand
    arms_ = false;
    if (pose->at.z_m >= kSurelyInTheAirM) Use();
  }
  if (!armed_) return std::nullopt;
  if (!known) {
    hold_.Reset();
    if (stands_) return std::nullopt;
    return navigation::Velocity{0, 0, low_ ? -kLastDescentMps : 0, 0};
  }
  stands_ = !place_ && pose->at.z_m < kInTheAirM;
  if (stands_) return std::nullopt;
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
  const bool stands = still_ >= kStands;
  if (stands && pose.at.z_m <= kGroundToleranceM) {
    Land();
    return std::nullopt;
  }
  navigation::Velocity command = hold_.Command(*place_, pose, PositionHold::SecondsOf(step));
  const bool slowly = stands || pose.at.z_m < kSlowBelowM;
  command.z_m_s = slowly ? -kLastDescentMps : -kDescentMps;
  return command;
}

}  // namespace musher::skills
