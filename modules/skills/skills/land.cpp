#include "musher/modules/skills/skills/land.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/skills/robot/landing_places.hpp"

namespace musher::skills {
namespace {

constexpr double kDescentMps = 0.5;
constexpr double kLastDescentMps = 0.2;
constexpr double kSlowBelowM = 0.5;
constexpr double kGroundToleranceM = 0.3;
constexpr double kStillM = 0.02;
constexpr double kStillS = 1;
constexpr std::string_view kLowest = "lowest_m";
constexpr std::string_view kStillFor = "still_for_s";
constexpr double kMostAsideM = 5;
constexpr double kHeldThereS = 2;  // at another place
constexpr double kThereM = 0.15;
constexpr double kBesideM = 0.15;             // between its body and what its scan sees
constexpr std::string_view kTaken = "taken";  // the place around which it looks for another one
constexpr std::string_view kTried = "places_tried";
constexpr std::string_view kTakenBy = "taken_by";
constexpr std::string_view kAsideTo = "aside_to";
constexpr std::string_view kAsideFrom = "aside_from";
constexpr std::string_view kAsideFor = "aside_for_s";
constexpr double kStandsForS = 1;  // commanded, and its pose does not change
constexpr double kStandsM = 0.05;

navigation::Point PointOf(const skill::Tick& tick, std::string_view key) {
  const auto values = tick.data.Get<skill::Numbers>(key, {});
  return values.size() == 3 ? navigation::Point{values[0], values[1], values[2]}
                            : navigation::Point{};
}

void SetPoint(skill::Tick& tick, std::string_view key, const navigation::Point& point) {
  tick.data.Set(key, skill::Numbers{point.x_m, point.y_m, point.z_m});
}

double Aside(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

void Land::Declare(skill::Table& table) {
  table.Does("Descends to the ground");
  table.Uses(kBase);
  table.Takes("ground_height", 0.0, "m above the zero of the map (absolute)");
  table.Takes("aside", 0.0, "m that it may go aside where its place is taken, 0 to 5");
  initializing_ = table.State("INITIALIZING");
  executing_ = table.State("EXECUTING", std::chrono::seconds(30));
  moving_aside_ = table.State("MOVING_ASIDE", std::chrono::seconds(8));
  table.To(initializing_, executing_, "the height is known");
  table.To(executing_, skill::kSucceeded, "its height stands still, at the ground");
  table.To(executing_, initializing_, "retry");
  table.To(executing_, moving_aside_, "its place is taken");
  table.To(moving_aside_, executing_, "it is there, or comes no nearer");
  TakesRetries(table);
  table.MonotoneProgress();
}

skill::Next Land::Fly(const navigation::Pose& now, skill::Tick& tick) {
  const double height_m = now.at.z_m;
  const double above_m = height_m - tick.parameters.Number("ground_height");
  tick.Detail("height_m", height_m);
  if (tick.state == initializing_) {
    const double aside_m = tick.parameters.Number("aside");
    if (!(aside_m >= 0 && aside_m <= kMostAsideM)) {
      return skill::Next::Fail("Invalid aside: " + HeightText(aside_m) +
                               " is not between 0 and 5 m");
    }
    Remember(now, tick);
    tick.data.Remove(kTaken);
    tick.data.Set(kTried, 0.0);
    tick.data.Set(kLowest, height_m);
    tick.data.Set(kStillFor, 0.0);
    tick.Report(0, "Landing");
    return skill::Next::To(executing_);
  }
  ExpectGround(tick.parameters.Number("ground_height"));
  if (tick.state == moving_aside_) return GoAside(now, tick);
  const double limit_s = tick.data.Find(kTaken) == nullptr ? kHeldS : kHeldThereS;
  if (auto why = HeldTooLong(now, tick, limit_s)) return Elsewhere(now, tick, std::move(*why));
  const bool held = !robot().WhyNotDescending().empty();
  const bool lower = height_m < tick.data.Number(kLowest) - kStillM;
  if (lower) tick.data.Set(kLowest, height_m);
  // Only time with a command counts: neither a pause, nor a time without odometry.
  const double still_s =
      lower || held ? 0 : tick.data.Number(kStillFor) + PositionHold::SecondsOf(tick.step);
  tick.data.Set(kStillFor, still_s);
  if (still_s >= kStillS && above_m <= kGroundToleranceM) {
    NoteLanding();
    const double aside_m =
        tick.data.Find(kTaken) == nullptr ? 0 : Aside(now.at, PointOf(tick, kTaken));
    if (aside_m < kLandingRingM / 2) return skill::Next::Succeed("Landed");
    return skill::Next::Succeed(fmt::format("Landed {:.1f} m aside: its place was taken", aside_m));
  }
  const navigation::Pose place = Remembered(tick);
  KeepWhile(above_m < kSlowBelowM ? -kLastDescentMps : -kDescentMps, place, now, tick);
  const double start_m = place.at.z_m - tick.parameters.Number("ground_height");
  const double progress = start_m > 0 ? std::min(100 * (1 - above_m / start_m), 95.0) : 95;
  tick.Report(progress, held ? robot().WhyNotDescending() : HeightText(height_m));
  return skill::Next::Stay();
}

skill::Next Land::Elsewhere(const navigation::Pose& now, skill::Tick& tick, std::string why) {
  const double most_m = tick.parameters.Number("aside");
  if (tick.data.Find(kTaken) == nullptr) SetPoint(tick, kTaken, now.at);
  const navigation::Point taken = PointOf(tick, kTaken);
  auto tried = static_cast<int>(tick.data.Number(kTried));
  while (auto place = LandingPlace(taken, tried, most_m)) {
    tick.data.Set(kTried, static_cast<double>(++tried));
    place->z_m = now.at.z_m;
    if (Aside(now.at, *place) <= kThereM) continue;
    if (!SeesTowards(*place, now) || !IsFreeWay(now.at, *place)) continue;
    SetPoint(tick, kAsideTo, *place);
    SetPoint(tick, kAsideFrom, now.at);
    tick.data.Set(kAsideFor, 0.0);
    tick.data.Set(kTakenBy, why);
    const double aside_m = Aside(taken, *place);
    return skill::Next::To(
        moving_aside_, aside_m > 0 ? fmt::format("Goes {:.1f} m aside to land: {}", aside_m, why)
                                   : "Goes back to its place to land: " + why);
  }
  if (tried > 0) {
    why += fmt::format("; none of {} places within {:g} m is free", PlacesAside(tried), most_m);
  }
  return AgainOrFail(tick, initializing_, std::move(why));
}

bool Land::SeesTowards(const navigation::Point& place, const navigation::Pose& now) const {
  const navigation::Velocity off =
      navigation::InBodyFrame({place.x_m - now.at.x_m, place.y_m - now.at.y_m, 0, 0}, now.yaw_rad);
  return robot().ScanCovers({off.x_m_s, off.y_m_s, 0});
}

bool Land::IsFreeWay(const navigation::Point& from, const navigation::Point& to) const {
  const double room_m = robot().radius_m() + kBesideM, length_m = Aside(from, to);
  return std::ranges::none_of(robot().obstacles(), [&](const navigation::Point& point) {
    const double along = ((point.x_m - from.x_m) * (to.x_m - from.x_m) +
                          (point.y_m - from.y_m) * (to.y_m - from.y_m)) /
                         std::max(length_m * length_m, 1e-9);
    // What is behind it blocks no way.
    return along > 0 && Aside(point, navigation::Between(from, to, std::min(along, 1.0))) < room_m;
  });
}

skill::Next Land::GoAside(const navigation::Pose& now, skill::Tick& tick) {
  const navigation::Pose to{PointOf(tick, kAsideTo), Remembered(tick).yaw_rad};
  if (Aside(now.at, to.at) <= kThereM) {
    Remember(to, tick);
    return skill::Next::To(executing_, HeightText(now.at.z_m));
  }
  if (!SeesTowards(to.at, now)) return skill::Next::To(executing_);
  // Its height says nothing either then: each place would look taken.
  const bool stands = Aside(now.at, PointOf(tick, kAsideFrom)) < kStandsM;
  const double stands_s = stands && robot().HeldBy().empty()
                              ? tick.data.Number(kAsideFor) + PositionHold::SecondsOf(tick.step)
                              : 0;
  tick.data.Set(kAsideFor, stands_s);
  if (stands_s >= kStandsForS) {
    return skill::Next::Fail(tick.data.Get<std::string>(kTakenBy, {}) +
                             "; commanded aside, but its odometry does not change");
  }
  Remember({now.at, to.yaw_rad}, tick);
  Keep(to, now, tick);
  return skill::Next::Stay();
}

skill::Next Land::OnLimit(skill::Tick& tick) {
  // Its gate holds it, or the wind does: it tries where it has come to.
  if (tick.state == moving_aside_) return skill::Next::To(executing_);
  if (tick.data.Number(kStillFor) < 2 * kStillS) return skill::Next::Stay();
  return AgainOrFail(tick, initializing_,
                     "Timeout: it stays at " + HeightText(tick.data.Number(kLowest)) +
                         ", the ground is at " +
                         HeightText(tick.parameters.Number("ground_height")));
}

}  // namespace musher::skills
