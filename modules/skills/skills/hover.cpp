#include "musher/modules/skills/skills/hover.hpp"

#include <fmt/format.h>

#include <cmath>

namespace musher::skills {
namespace {

constexpr double kWithinM = 0.1;
constexpr double kSpareS = 30;
constexpr double kBrakedMps = 0.15;
constexpr double kLongestBrakingS = 1;  // a wind does not brake
constexpr std::string_view kHeld = "held_s";
constexpr const char* kOnTheGround = "The robot stands on the ground; take off first";

}  // namespace

void Hover::Declare(skill::Table& table) {
  table.Does("Goes to an altitude and holds its place there for a time");
  table.Uses(kBase);
  table.Takes("altitude", 2.0, "m above the zero of the map (absolute); 0: where it is");
  table.Takes("duration", 5.0, "seconds, 0 or more");
  table.Takes("ceiling", 0.0, "m above the zero of the map, lowers that of the robot; 0: that one");
  initializing_ = table.State("INITIALIZING");
  approaching_ = table.State("APPROACHING", std::chrono::seconds(30));
  hovering_ = table.State("HOVERING");
  table.To(initializing_, approaching_, "the robot flies");
  table.To(approaching_, hovering_, "within 0.1 m of the altitude");
  table.To(hovering_, skill::kSucceeded, "the duration is over");
  table.MonotoneProgress();
  table.Limit({.run = skill::kNoLimit});
}

skill::Next Hover::Check(const navigation::Pose& now, skill::Tick& tick) {
  const double altitude_m = tick.parameters.Number("altitude");
  const double ceiling_m = Ceiling(tick);
  if (altitude_m < 0 || altitude_m > ceiling_m) {
    return skill::Next::Fail("Invalid altitude: " + HeightText(altitude_m) +
                             " is not between the ground and the ceiling of " +
                             HeightText(ceiling_m));
  }
  if (tick.parameters.Number("duration") < 0) {
    return skill::Next::Fail("Invalid duration: it is negative");
  }
  if (now.at.z_m < kStandsBelowM) return skill::Next::Fail(kOnTheGround);
  const bool moves = navigation::Speed(robot().velocity()) > kBrakedMps;
  if (moves && ToSeconds(tick.elapsed) < kLongestBrakingS) {
    KeepWhile(0, now, now, tick);
    tick.Report(0, "Braking");
    return skill::Next::Stay();
  }
  navigation::Pose place = now;
  if (altitude_m > 0) place.at.z_m = altitude_m;
  Remember(place, tick);
  tick.data.Set(kHeld, 0.0);
  tick.Report(0, "Going to " + HeightText(place.at.z_m));
  return skill::Next::To(approaching_);
}

skill::Next Hover::Approach(const navigation::Pose& now, skill::Tick& tick) {
  const navigation::Pose place = Remembered(tick);
  if (auto why = HeldTooLong(now, tick)) return skill::Next::Fail(std::move(*why));
  Keep(place, now, tick);
  if (std::abs(now.at.z_m - place.at.z_m) <= kWithinM) return skill::Next::To(hovering_);
  tick.Report(0, "Going to " + HeightText(place.at.z_m));
  return skill::Next::Stay();
}

skill::Next Hover::Hold(const navigation::Pose& now, skill::Tick& tick) {
  const navigation::Pose place = Remembered(tick);
  const double duration_s = tick.parameters.Number("duration");
  const bool within = std::abs(now.at.z_m - place.at.z_m) <= kWithinM;
  double held_s = tick.data.Number(kHeld);
  if (within && !tick.entered) held_s += ToSeconds(tick.step);
  tick.data.Set(kHeld, held_s);
  tick.Detail("held_s", held_s);
  tick.Detail("off_place_m", navigation::Distance(now.at, place.at));
  if (held_s >= duration_s) return skill::Next::Succeed("Hovered");
  if (ToSeconds(tick.elapsed) > duration_s + kSpareS) {
    return skill::Next::Fail(
        fmt::format("Timeout: held the height for {:.1f} of {:.1f} s", held_s, duration_s));
  }
  Keep(place, now, tick);
  tick.Report(100 * held_s / duration_s, fmt::format("Hovering ({:.1f}s)", held_s));
  return skill::Next::Stay();
}

Result<> Hover::MayResume() {
  const auto now = robot().pose();
  if (now && now->at.z_m < kStandsBelowM) return Error{kCodeStateInvalid, kOnTheGround};
  const std::string why = robot().WhyNotHeld();
  return why.empty() ? Ok() : Result<>(Error{kCodeStateInvalid, why});
}

skill::Next Hover::Fly(const navigation::Pose& now, skill::Tick& tick) {
  tick.Detail("height_m", now.at.z_m);
  if (tick.state == initializing_) return Check(now, tick);
  return tick.state == approaching_ ? Approach(now, tick) : Hold(now, tick);
}

skill::Next Hover::OnLimit(skill::Tick& tick) {
  return skill::Next::Fail("Timeout: not at " + HeightText(Remembered(tick).at.z_m) + " after " +
                           skill::SecondsText(tick.elapsed));
}

}  // namespace musher::skills
