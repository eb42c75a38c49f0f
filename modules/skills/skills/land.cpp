#include "musher/modules/skills/skills/land.hpp"

#include <algorithm>

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

}  // namespace

void Land::Declare(skill::Table& table) {
  table.Does("Descends to the ground");
  table.Uses(kBase);
  table.Takes("ground_height", 0.0, "m above the zero of the map (absolute)");
  initializing_ = table.State("INITIALIZING");
  executing_ = table.State("EXECUTING", std::chrono::seconds(30));
  table.To(initializing_, executing_, "the height is known");
  table.To(executing_, skill::kSucceeded, "its height stands still, at the ground");
  table.To(executing_, initializing_, "retry");
  TakesRetries(table);
  table.MonotoneProgress();
}

skill::Next Land::Fly(const navigation::Pose& now, skill::Tick& tick) {
  const double height_m = now.at.z_m;
  const double above_m = height_m - tick.parameters.Number("ground_height");
  tick.Detail("height_m", height_m);
  if (tick.state == initializing_) {
    Remember(now, tick);
    tick.data.Set(kLowest, height_m);
    tick.data.Set(kStillFor, 0.0);
    tick.Report(0, "Landing");
    return skill::Next::To(executing_);
  }
  ExpectGround(tick.parameters.Number("ground_height"));
  if (auto why = HeldTooLong(now, tick)) return AgainOrFail(tick, initializing_, std::move(*why));
  const bool held = !robot().WhyNotDescending().empty();
  const bool lower = height_m < tick.data.Number(kLowest) - kStillM;
  if (lower) tick.data.Set(kLowest, height_m);
  // Only time with a command counts: neither a pause, nor a time without odometry.
  const double still_s =
      lower || held ? 0 : tick.data.Number(kStillFor) + PositionHold::SecondsOf(tick.step);
  tick.data.Set(kStillFor, still_s);
  if (still_s >= kStillS && above_m <= kGroundToleranceM) {
    NoteLanding();
    return skill::Next::Succeed("Landed");
  }
  const navigation::Pose place = Remembered(tick);
  KeepWhile(above_m < kSlowBelowM ? -kLastDescentMps : -kDescentMps, place, now, tick);
  const double start_m = place.at.z_m - tick.parameters.Number("ground_height");
  const double progress = start_m > 0 ? std::min(100 * (1 - above_m / start_m), 95.0) : 95;
  tick.Report(progress, held ? robot().WhyNotDescending() : HeightText(height_m));
  return skill::Next::Stay();
}

skill::Next Land::OnLimit(skill::Tick& tick) {
  if (tick.data.Number(kStillFor) < 2 * kStillS) return skill::Next::Stay();
  return AgainOrFail(tick, initializing_,
                     "Timeout: it stays at " + HeightText(tick.data.Number(kLowest)) +
                         ", the ground is at " +
                         HeightText(tick.parameters.Number("ground_height")));
}

}  // namespace musher::skills
