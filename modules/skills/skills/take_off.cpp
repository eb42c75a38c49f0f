#include "musher/modules/skills/skills/take_off.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace musher::skills {
namespace {

constexpr double kReachedM = 0.1;
constexpr double kSurelyInTheAirM = 0.3;      // the zero of an odometry is not just at the ground
constexpr double kLeastRiseM = 0.1;           // from where it may stand; less may be its odometry
constexpr std::string_view kFrom = "from_m";  // where it may have stood
constexpr double kLowestShare = 0.8;  // of a low altitude, which is less than kReachedM above it
constexpr double kMostProgress = 95;

double ReachedAt(double altitude_m) {
  return std::max(altitude_m - kReachedM, kLowestShare * altitude_m);
}

}  // namespace

void TakeOff::Declare(skill::Table& table) {
  table.Does("Climbs to an altitude and hovers there");
  table.Uses(kBase);
  table.Takes("altitude", 1.0, "m above the zero of the map (absolute)");
  table.Takes("ceiling", 0.0, "m above the zero of the map, lowers that of the robot; 0: that one");
  initializing_ = table.State("INITIALIZING");
  executing_ = table.State("EXECUTING", std::chrono::seconds(30));
  table.To(initializing_, executing_, "the altitude is above the robot");
  table.To(initializing_, skill::kSucceeded, "the altitude is reached already");
  table.To(executing_, skill::kSucceeded, "at most 0.1 m below the altitude");
  table.To(executing_, initializing_, "retry");
  TakesRetries(table);
  table.MonotoneProgress();
}

skill::Next TakeOff::Check(const navigation::Pose& now, skill::Tick& tick) {
  const double altitude_m = tick.parameters.Number("altitude");
  const double ceiling_m = Ceiling(tick);
  if (altitude_m <= 0) {
    return skill::Next::Fail("Invalid altitude: " + HeightText(altitude_m) +
                             " is not above the ground");
  }
  if (altitude_m > ceiling_m) {
    return skill::Next::Fail("Invalid altitude: " + HeightText(altitude_m) +
                             " is above the ceiling of " + HeightText(ceiling_m));
  }
  if (now.at.z_m > altitude_m + kReachedM) {
    return skill::Next::Fail("Invalid altitude: the robot is higher already, at " +
                             HeightText(now.at.z_m) + "; use hover to descend to " +
                             HeightText(altitude_m));
  }
  const bool may_stand = now.at.z_m < kSurelyInTheAirM;
  if (!may_stand && now.at.z_m >= ReachedAt(altitude_m)) {
    return skill::Next::Succeed("Reached altitude");
  }
  if (may_stand && altitude_m < now.at.z_m + kLeastRiseM) {
    return skill::Next::Fail(
        fmt::format("Invalid altitude: {:.2f} m is not {:g} m above the robot, which is at {:.2f} "
                    "m and may stand on the ground",
                    altitude_m, kLeastRiseM, now.at.z_m));
  }
  tick.data.Set(kFrom, now.at.z_m);
  navigation::Pose place = now;
  place.at.z_m = altitude_m;
  Remember(place, tick);
  tick.Report(10, "Taking off");
  return skill::Next::To(executing_);
}

skill::Next TakeOff::Fly(const navigation::Pose& now, skill::Tick& tick) {
  if (tick.state == initializing_) return Check(now, tick);
  const navigation::Pose place = Remembered(tick);
  tick.Detail("height_m", now.at.z_m);
  // One that may stand has to rise: its height alone does not show that it flies.
  const double from_m = tick.data.Number(kFrom);
  const double risen_m = from_m < kSurelyInTheAirM ? (from_m + place.at.z_m) / 2 : from_m;
  const double reached_m = std::max(ReachedAt(place.at.z_m), risen_m);
  if (now.at.z_m >= reached_m) return skill::Next::Succeed("Reached altitude");
  Keep(place, now, tick);
  tick.Report(std::min(100 * now.at.z_m / place.at.z_m, kMostProgress), HeightText(now.at.z_m));
  return skill::Next::Stay();
}

skill::Next TakeOff::OnLimit(skill::Tick& tick) {
  return AgainOrFail(tick, initializing_,
                     "Timeout: not at " + HeightText(Remembered(tick).at.z_m) + " after " +
                         skill::SecondsText(tick.elapsed));
}

}  // namespace musher::skills
