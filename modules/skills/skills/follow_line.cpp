#include "musher/modules/skills/skills/follow_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "musher/modules/skills/skills/vector_field.hpp"

namespace musher::skills {
namespace {

using skill::Next;
using skill::Tick;

constexpr double kMostMPerS = 1;
constexpr double kMostRadPerS = 1;
constexpr double kKeptAheadM = 0.1;  // between the robot and what is ahead
constexpr double kLineLookedM = 2;
constexpr Duration kLineBlockedLimit = std::chrono::seconds(10);
constexpr std::string_view kFollowed = "followed_m";

// Turns to the line and along it; slower, the farther it is off.
navigation::Velocity Steered(const Robot::Line& line, double speed_m_s) {
  constexpr double kByOffset = 1.5;   // rad/s for a metre
  constexpr double kByHeading = 2.0;  // rad/s for a radian
  constexpr double kFarM = 0.5, kFarRad = 1, kSlowest = 0.2;
  const double off =
      std::max(std::abs(line.offset_m) / kFarM, std::abs(line.heading_rad) / kFarRad);
  const double turn = kByOffset * line.offset_m + kByHeading * line.heading_rad;
  return {.x_m_s = speed_m_s * std::clamp(1 - off, kSlowest, 1.0),
          .yaw_rad_s = std::clamp(turn, -kMostRadPerS, kMostRadPerS)};
}

}  // namespace

void FollowLine::Declare(skill::Table& table) {
  initializing_ = table.State("INITIALIZING", kServerWait);
  executing_ = table.State("EXECUTING");
  searching_ = table.State("SEARCHING", std::chrono::seconds(8));
  stopping_ = table.State("STOPPING");
  table.To(initializing_, executing_, "the line is seen");
  table.To(executing_, searching_, "the line is lost");
  table.To(searching_, executing_, "the line is seen");
  table.To(executing_, stopping_, "the distance is done, or cancel");
  for (const skill::StateId state : {initializing_, executing_, searching_}) {
    if (state != executing_) table.To(state, stopping_, "cancel");
    table.To(state, skill::kFailed, "failed");
  }
  table.To(stopping_, skill::kSucceeded, "the robot stands after the distance");
  table.To(stopping_, skill::kCancelled, "the robot stands");
  table.Limit({.run = skill::kNoLimit});
  table.MonotoneProgress();
  table.Does("Drives along the line that the robot sees");
  table.Uses(kBase);
  table.Takes("speed", 0.3, "m/s, at most 1.0");
  table.Takes("distance", 0.0, "m, 0: until it is cancelled");
}

std::optional<std::string> FollowLine::WhyRefused(const skill::Values& parameters) const {
  const double speed = parameters.Number("speed"), distance = parameters.Number("distance");
  if (robot_.flies()) {
    return robot_.name() + " flies; follow_line is for robots on the ground";
  }
  if (speed <= 0 || speed > kMostMPerS) {
    return fmt::format("speed is {:g} m/s; expected more than 0 and at most {:g} m/s", speed,
                       kMostMPerS);
  }
  if (distance < 0) return fmt::format("distance is {:g} m; expected 0 m or more", distance);
  return std::nullopt;
}

Next FollowLine::Step(Tick& tick) {
  if (tick.state == stopping_) {
    return Stop(tick, fmt::format("Followed the line for {:.1f} m", tick.data.Number(kFollowed)));
  }
  if (const auto why = WhyRefused(tick.parameters)) return Next::Fail(*why);
  if (tick.state == searching_) return Search(tick);
  if (tick.state == executing_) return Execute(tick);
  tick.Report(5, "Waiting for the line");
  return robot_.line() && robot_.pose() ? Next::To(executing_) : Next::Stay();
}

double FollowLine::Followed(Tick& tick) {
  double followed_m = tick.data.Number(kFollowed);
  const navigation::Point way = WaySince(last_, robot_);
  followed_m += std::hypot(way.x_m, way.y_m);
  tick.data.Set(kFollowed, followed_m);
  tick.Detail("followed", followed_m);
  return followed_m;
}

Next FollowLine::Execute(Tick& tick) {
  const double followed_m = Followed(tick);
  const double distance_m = tick.parameters.Number("distance");
  if (distance_m > 0 && followed_m >= distance_m) return Complete(tick);
  blind_ = robot_.pose() ? Duration{} : blind_ + tick.step;
  if (blind_ >= kLostAfter) return Next::Fail(robot_.WhyNoPose());
  const auto line = robot_.line();
  if (!line || !std::isfinite(line->offset_m) || !std::isfinite(line->heading_rad)) {
    robot_.SetVelocity({});
    return Next::To(searching_);
  }
  side_ = line->offset_m + line->heading_rad >= 0 ? 1 : -1;
  tick.Report(distance_m > 0 ? 10 + 85 * followed_m / distance_m : 50,
              fmt::format("Following the line... ({:.1f} m)", followed_m));
  tick.Detail("offset", line->offset_m);
  tick.Detail("heading", line->heading_rad);
  const auto pose = robot_.pose();
  if (!pose) {
    robot_.SetVelocity({});
    return Next::Stay();
  }
  const navigation::Velocity wanted = Steered(*line, tick.parameters.Number("speed"));
  robot_.SetVelocity(BeforeObstacles(wanted, *pose, tick));
  if (blocked_ == Duration{}) return Next::Stay();
  const std::string held = robot_.HeldBy();
  const std::string why = held.empty()
                              ? fmt::format("an obstacle is on the line at ({:.1f}, {:.1f})",
                                            pose->at.x_m, pose->at.y_m)
                              : held;
  if (blocked_ >= kLineBlockedLimit) {
    return Next::Fail(fmt::format("Blocked for {:.1f} s: {}", ToSeconds(blocked_), why));
  }
  tick.Report(0, fmt::format("Blocked ({:.1f}s): {}", ToSeconds(blocked_), why));
  return Next::Stay();
}

navigation::Velocity FollowLine::BeforeObstacles(const navigation::Velocity& wanted,
                                                 const navigation::Pose& pose, Tick& tick) {
  constexpr double kStandsMPerS = 0.02;
  const double free_m = FreeAhead(SeenAround(robot_, pose, kLineLookedM), robot_.radius_m(),
                                  kKeptAheadM, kLineLookedM);
  const double safe_m_s = SafeSpeed(free_m);
  tick.Detail("free_ahead", free_m);
  const bool stands = safe_m_s < kStandsMPerS || !robot_.HeldBy().empty();
  blocked_ = stands ? blocked_ + tick.step : Duration{};
  if (safe_m_s < kStandsMPerS) return {};
  const double share = std::min(1.0, safe_m_s / wanted.x_m_s);
  return {.x_m_s = share * wanted.x_m_s, .yaw_rad_s = share * wanted.yaw_rad_s};
}

Next FollowLine::Search(Tick& tick) {
  Followed(tick);
  if (robot_.line() && robot_.pose()) {
    robot_.SetVelocity({});
    return Next::To(executing_);
  }
  constexpr double kTurnRadPerS = 0.5;
  constexpr double kToOneSideS = 2.1;    // 60 degrees
  constexpr double kToOtherSideS = 4.2;  // and back, and 60 degrees more
  const double searched_s = ToSeconds(tick.elapsed);
  double turn = 0;
  if (searched_s < kToOneSideS) {
    turn = side_ * kTurnRadPerS;
  } else if (searched_s < kToOneSideS + kToOtherSideS) {
    turn = -side_ * kTurnRadPerS;
  }
  robot_.SetVelocity({.yaw_rad_s = turn});
  tick.Report(0, fmt::format("Line lost, searching... ({:.1f}s)", searched_s));
  return Next::Stay();
}

Next FollowLine::OnLimit(Tick& tick) {
  if (tick.state == searching_) {
    const std::string held = robot_.HeldBy();
    return Next::Fail("Line lost: " + (held.empty() ? "not found by turning to both sides" : held));
  }
  if (!robot_.pose()) return Next::Fail(robot_.WhyNoPose());
  return Next::Fail("No line in sight of " + robot_.name());
}

void FollowLine::OnPause() {
  last_.reset();
  TravelSkill::OnPause();
}

}  // namespace musher::skills
