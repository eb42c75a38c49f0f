#include "musher/modules/skills/robot/flight_hold.hpp"

namespace musher::skills {
namespace {

constexpr double kBrakedMS = 0.15;
constexpr Duration kLongestBraking = std::chrono::seconds(1);  // a wind does not brake

}  // namespace

void FlightHold::Use() {
  armed_ = true;
  braking_ = {};
  place_.reset();
  hold_.Reset();
}

std::optional<navigation::Velocity> FlightHold::Command(const std::optional<navigation::Pose>& pose,
                                                        double speed_m_s, Duration step) {
  if (!armed_) return std::nullopt;
  if (!pose || !navigation::IsFinite(*pose)) {
    hold_.Reset();
    return navigation::Velocity{};
  }
  if (!place_ && pose->at.z_m < kInTheAirM) return std::nullopt;
  braking_ += step;
  if (!place_ && speed_m_s > kBrakedMS && braking_ < kLongestBraking) return navigation::Velocity{};
  if (!place_) place_ = pose;
  if (navigation::Distance(pose->at, place_->at) > kLostM) {
    armed_ = false;
    return std::nullopt;
  }
  return hold_.Command(*place_, *pose, PositionHold::SecondsOf(step));
}

}  // namespace musher::skills
