#include "musher/modules/skills/skills/navigate_to.hpp"
#include "musher/base/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

Error BadPlace(std::string message) {
  return {kCodeParametersInvalid, std::move(message)};
}

// The direction in which a body with this rotation (w x y z) looks.
Result<double> YawOf(const skill::Numbers& quaternion, const std::string& name) {
  if (quaternion.size() != 4) {
    return BadPlace(fmt::format("{} has {}; expected 4: w, x, y, z", name,
                                Counted(quaternion.size(), "number")));
  }
  double longest = 0;
  for (const double part : quaternion) longest = std::max(longest, std::abs(part));
  if (longest == 0) {
    return BadPlace(name + " has the length 0; expected a rotation, such as [1, 0, 0, 0]");
  }
  const double w = quaternion[0] / longest, x = quaternion[1] / longest;
  const double y = quaternion[2] / longest, z = quaternion[3] / longest;
  return std::atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z);
}

}  // namespace

void NavigateTo::Describe(skill::Table& table) {
  table.Does("Travels to a place and looks in a direction there");
  table.Uses(kBase);
  table.Needs("goal_pos", skill::Kind::kNumbers,
              for_ == For::kGround ? "m, x y in the map" : "m, x y z in the map");
  table.Takes("goal_quat_wxyz", skill::Numbers{1, 0, 0, 0}, "the direction at the goal");
  table.Takes("start_pos", skill::Numbers{}, "m, in the map; empty: where the robot is");
  table.Takes("start_quat", skill::Numbers{}, "the direction there; empty: as the robot looks");
  if (for_ != For::kAir) table.Takes("ground_height", 0.0, "m, of the map's ground");
}

Result<navigation::Point> NavigateTo::PlaceOf(const skill::Values& parameters,
                                              const std::string& name) const {
  const skill::Numbers numbers = parameters.Get<skill::Numbers>(name, {});
  const bool flies = robot().flies();
  if (numbers.size() != 3 && (flies || numbers.size() != 2)) {
    return BadPlace(
        fmt::format("{} has {}; expected {}", name, Counted(numbers.size(), "number"),
                    flies ? "3: x, y and z in the map" : "2 or 3: x, y and z in the map"));
  }
  const navigation::Point place{numbers[0], numbers[1],
                                flies ? numbers[2] : parameters.Number("ground_height")};
  if (!IsFinite(place)) return BadPlace(name + " is not finite");
  const Result<> altitude = CheckAltitude(robot(), name, place.z_m);
  if (!altitude) return altitude.error();
  return place;
}

Result<> NavigateTo::Take(const skill::Tick& tick) {
  const bool flies = robot().flies();
  if (for_ == For::kGround && flies) {
    return BadPlace(robot().name() + " flies; nav_2d is for robots on the ground, use nav_3d");
  }
  if (for_ == For::kAir && !flies) {
    return BadPlace(robot().name() + " does not fly; nav_3d is for flyers, use nav_2d");
  }
  const auto goal = PlaceOf(tick.parameters, "goal_pos");
  if (!goal) return goal.error();
  const auto yaw =
      YawOf(tick.parameters.Get<skill::Numbers>("goal_quat_wxyz", {}), "goal_quat_wxyz");
  if (!yaw) return yaw.error();
  goal_ = {goal.value(), yaw.value()};
  const skill::Numbers start_quaternion = tick.parameters.Get<skill::Numbers>("start_quat", {});
  if (tick.parameters.Get<skill::Numbers>("start_pos", {}).empty()) {
    if (start_quaternion.empty()) return Ok();
    return BadPlace("start_quat is given without start_pos");
  }
  const auto start = PlaceOf(tick.parameters, "start_pos");
  if (!start) return start.error();
  start_ = navigation::Pose{start.value(), robot().pose() ? robot().pose()->yaw_rad : 0};
  if (start_quaternion.empty()) return Ok();
  const auto start_yaw = YawOf(start_quaternion, "start_quat");
  if (!start_yaw) return start_yaw.error();
  start_->yaw_rad = start_yaw.value();
  return Ok();
}

std::optional<std::string> NavigateTo::OnArrival(skill::Tick& /*tick*/) {
  return "Reached goal";
}

}  // namespace musher::skills
