#include "musher/modules/skills/skills/flight_skill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::skills {
namespace {

constexpr double kOdometryLimitS = 2;
constexpr std::string_view kBlindSince = "odometry_missing_since_s";
constexpr std::string_view kPlace = "place";
constexpr std::string_view kHeldFor = "descent_held_s";
constexpr std::string_view kHeldAt = "descent_held_at_m";
constexpr std::string_view kFlew = "flew";  // it was in the air
constexpr double kFlightJumpM = 1;          // a correction of a localisation is less
constexpr double kFlightYawRadS = 2;

}  // namespace

std::string HeightText(double height_m) {
  // A request may have any number.
  return std::abs(height_m) < 1e6 ? fmt::format("{:.1f}m", height_m)
                                  : fmt::format("{:.1e}m", height_m);
}

FlightSkill::FlightSkill(Robot& robot)
    : robot_(robot),
      guard_({.yaw_rad_s = kFlightYawRadS, .jump_m = kFlightJumpM, .drifts = true}) {}

skill::Next FlightSkill::Step(skill::Tick& tick) {
  if (!robot_.flies()) {
    return skill::Next::Fail(
        fmt::format("{} is a {}, which cannot fly", robot_.name(), robot_.kind()));
  }
  const auto now = robot_.pose();
  if (!now || !navigation::IsFinite(*now)) return WaitForOdometry(tick);
  const bool was_blind = tick.data.Find(kBlindSince) != nullptr;
  tick.data.Remove(kBlindSince);
  if (const auto taken = WhyTaken(*now, tick)) return skill::Next::Fail(*taken);
  if (const auto lost = WhyLost(*now, was_blind, tick)) return skill::Next::Fail(*lost);
  last_ = now;
  return Fly(*now, tick);
}

std::optional<std::string> FlightSkill::WhyTaken(const navigation::Pose& now,
                                                 skill::Tick& tick) const {
  const bool flies = now.at.z_m >= kStandsBelowM;
  const bool flew = tick.data.Get(kFlew, false);
  if (flies && !flew) tick.data.Set(kFlew, true);
  const bool goes_on = flew && !last_;
  if (!goes_on || !KeepsItsPlace()) return std::nullopt;
  if (!flies) return "it was in the air before, and stands on the ground now; take off first";
  std::string why = robot_.WhyNotHeld();
  return why.empty() ? std::nullopt : std::optional(std::move(why));
}

std::optional<std::string> FlightSkill::WhyLost(const navigation::Pose& now, bool was_blind,
                                                skill::Tick& tick) {
  if (const auto jump = guard_.OnPose(now, Duration::zero(), robot_.Now())) return jump->message;
  const double height_change_m = was_blind && last_ ? std::abs(now.at.z_m - last_->at.z_m) : 0;
  if (height_change_m > kOffPlaceM) {
    return fmt::format("its height has jumped by {:.1f} m while no odometry came", height_change_m);
  }
  if (tick.data.Find(kPlace) == nullptr) return std::nullopt;
  const navigation::Pose place = Remembered(tick);
  const double off_m = std::hypot(now.at.x_m - place.at.x_m, now.at.y_m - place.at.y_m);
  if (off_m <= kOffPlaceM) return std::nullopt;
  if (!KeepsItsPlace()) {
    Remember({{now.at.x_m, now.at.y_m, place.at.z_m}, place.yaw_rad}, tick);
    return std::nullopt;
  }
  return fmt::format("it is {:.1f} m off its place: it was carried there, or its pose is wrong",
                     off_m);
}

skill::Next FlightSkill::WaitForOdometry(skill::Tick& tick) {
  robot_.StopMotion();
  hold_.Reset();
  const double now_s = ToSeconds(tick.now);
  if (tick.data.Find(kBlindSince) == nullptr) tick.data.Set(kBlindSince, now_s);
  if (now_s - tick.data.Number(kBlindSince) >= kOdometryLimitS) {
    return skill::Next::Fail(robot_.WhyNoPose() + " for 2 s");
  }
  tick.Report(0, "Waiting for odometry");
  return skill::Next::Stay();
}

skill::Next FlightSkill::Cancel(skill::Tick& /*tick*/) {
  robot_.StopMotion();
  return skill::Next::Cancelled();
}

void FlightSkill::OnEnd(const skill::Ended& ended) {
  if (!ended.paused) robot_.StopMotion();
}

void FlightSkill::OnPause() {
  robot_.StopMotion();
  hold_.Reset();
  last_.reset();
}

void FlightSkill::TakesRetries(skill::Table& table) {
  table.Takes("retries", std::int64_t{0}, "attempts after the first one, 0 to 10");
  table.Limit({.retries = 10});
}

skill::Next FlightSkill::AgainOrFail(const skill::Tick& tick, skill::StateId state,
                                     std::string why) {
  if (tick.retries >= tick.parameters.Get<std::int64_t>("retries", 0)) {
    return skill::Next::Fail(std::move(why));
  }
  return skill::Next::Retry(state, std::move(why));
}

std::optional<std::string> FlightSkill::HeldTooLong(const navigation::Pose& now, skill::Tick& tick,
                                                    double limit_s) const {
  constexpr double kLowerM = 0.05;
  std::string why = robot_.WhyNotDescending();
  const double before_s = tick.data.Number(kHeldFor);
  const bool lower = before_s > 0 && now.at.z_m < tick.data.Number(kHeldAt) - kLowerM;
  const bool held = !why.empty() && !lower;
  if (!held || before_s == 0) tick.data.Set(kHeldAt, now.at.z_m);
  const double held_s = held ? before_s + PositionHold::SecondsOf(tick.step) : 0;
  const bool too_long = held_s >= limit_s;
  tick.data.Set(kHeldFor, too_long ? 0 : held_s);
  return too_long ? std::optional(std::move(why)) : std::nullopt;
}

double FlightSkill::Ceiling(const skill::Tick& tick) const {
  constexpr double kUsualM = 10;
  const double robot_m = robot_.ceiling_m().value_or(kUsualM);
  const double goal_m = tick.parameters.Number("ceiling");
  return goal_m > 0 ? std::min(goal_m, robot_m) : robot_m;
}

void FlightSkill::Keep(const navigation::Pose& place, const navigation::Pose& now,
                       const skill::Tick& tick) {
  robot_.SetVelocity(hold_.Command(place, now, PositionHold::SecondsOf(tick.step)));
}

void FlightSkill::KeepWhile(double climb_mps, const navigation::Pose& place,
                            const navigation::Pose& now, const skill::Tick& tick) {
  navigation::Pose level = place;
  level.at.z_m = now.at.z_m;
  navigation::Velocity command = hold_.Command(level, now, PositionHold::SecondsOf(tick.step));
  command.z_m_s = climb_mps;
  robot_.SetVelocity(command);
}

void FlightSkill::Remember(const navigation::Pose& place, skill::Tick& tick) {
  tick.data.Set(kPlace, skill::Numbers{place.at.x_m, place.at.y_m, place.at.z_m, place.yaw_rad});
}

navigation::Pose FlightSkill::Remembered(const skill::Tick& tick) {
  const auto values = tick.data.Get<skill::Numbers>(kPlace, {});
  if (values.size() != 4) return {};
  return {{values[0], values[1], values[2]}, values[3]};
}

}  // namespace musher::skills
