#include "musher/modules/skills/skills/servo_drive.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

namespace musher::skills {
namespace {

using Kind = ServoDriveStep::Kind;

constexpr Duration kServoBlockedLimit = std::chrono::seconds(10);
constexpr double kBehindM = 0.2;  // behind its edge
constexpr double kStillMPerS = 0.02, kStillRadPerS = 0.05;

bool IsStill(const Robot& robot) {
  const navigation::Velocity velocity = robot.velocity();
  return navigation::Speed(velocity) <= kStillMPerS &&
         std::abs(velocity.yaw_rad_s) <= kStillRadPerS;
}

}  // namespace

std::optional<std::string> ServoDrive::Missing() const {
  const auto pose = robot_.pose();
  if (!pose || !navigation::IsFinite(*pose)) return robot_.WhyNoPose();
  if (!robot_.HasScan()) return "No scan of " + robot_.name();
  return std::nullopt;
}

std::string ServoDrive::PlaceText() const {
  if (!target_) return rules_.target + " was not seen";
  const double bearing_rad = BearingOf(*target_);
  return fmt::format("{} is {:.2f} m away, {:.2f} rad to the {}", rules_.target,
                     LevelDistanceTo(*target_), std::abs(bearing_rad),
                     bearing_rad >= 0 ? "left" : "right");
}

ServoDriveStep ServoDrive::Stand(Duration step, const std::string& why) {
  robot_.SetVelocity({});
  standing_ += step;
  const Kind kind = ToSeconds(standing_) >= lost_limit_s_ ? Kind::kFailed : Kind::kPending;
  return {kind, why, target_};
}

ServoDriveStep ServoDrive::Step(Duration step) {
  const auto look = robot_.LookFor(rules_.target);
  const auto missing = Missing();
  const ServoStep wanted =
      servo_.Update(look, robot_.WhyNoLook(), !missing && IsStill(robot_), robot_.Now());
  target_ = wanted.target;
  if (missing) return Stand(step, *missing);
  if (wanted.kind == ServoStep::Kind::kStands) return Stand(step, wanted.why);
  const bool backwards = wanted.command.x_m_s < 0;
  if (backwards && !robot_.ScanCovers({-robot_.radius_m() - kBehindM, 0, 0})) {
    return Stand(step, "it is too near, and no scan covers what is behind it");
  }
  standing_ = {};
  robot_.SetVelocity(wanted.command);
  if (wanted.kind == ServoStep::Kind::kReached) return {Kind::kReached, PlaceText(), target_};
  if (wanted.kind == ServoStep::Kind::kSettles) {
    blocked_ = {};
    return {Kind::kPending, "Standing before " + rules_.target, target_};
  }
  const std::string held = robot_.HeldBy();
  blocked_ = held.empty() ? Duration{} : blocked_ + step;
  if (blocked_ >= kServoBlockedLimit) return {Kind::kFailed, "Blocked: " + held, target_};
  return {Kind::kPending, held.empty() ? "Approaching " + rules_.target : "Blocked: " + held,
          target_};
}

}  // namespace musher::skills
