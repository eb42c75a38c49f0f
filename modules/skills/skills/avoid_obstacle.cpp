#include "musher/modules/skills/skills/avoid_obstacle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "musher/base/words.hpp"
#include "musher/modules/skills/skills/vector_field.hpp"

namespace musher::skills {
namespace {

using skill::Next;
using skill::Tick;

constexpr double kFastestMPerS = 1;
constexpr double kArrivedM = 0.2;
constexpr double kLookedM = 2;
constexpr double kKeptM = 0.05;  // between the robot and an obstacle, at least
constexpr Duration kProgressLimit = std::chrono::seconds(30);
constexpr std::string_view kBeginYaw = "begin_yaw_rad";  // data, in the frame of the odometry
constexpr std::string_view kGone = "gone_m";             // data, in the direction of `heading`

}  // namespace

void AvoidObstacle::Declare(skill::Table& table) {
  initializing_ = table.State("INITIALIZING", kServerWait);
  executing_ = table.State("EXECUTING", std::chrono::seconds(120));
  stopping_ = table.State("STOPPING");
  table.To(initializing_, executing_, "scan and odometry are there");
  table.To(executing_, stopping_, "at the goal, or cancel");
  table.To(initializing_, stopping_, "cancel");
  table.To(initializing_, skill::kFailed, "failed");
  table.To(executing_, skill::kFailed, "blocked, or failed");
  table.To(stopping_, skill::kSucceeded, "the robot stands at the goal");
  table.To(stopping_, skill::kCancelled, "the robot stands");
  table.MonotoneProgress();
  table.Does("Goes to a place or in a direction, clear of what the scan sees");
  table.Uses(kBase);
  table.Takes("goal_pos", skill::Numbers{}, "m, x y in the map; empty: by heading");
  table.Takes("heading", 0.0, "rad to the left of where the robot looks");
  table.Takes("distance", 3.0, "m in that direction");
  table.Takes("speed", 0.3, "m/s, at most 1.0");
  table.Takes("blocked_limit", 10.0, "s without a free direction, then it fails");
}

std::optional<std::string> AvoidObstacle::WhyRefused(const skill::Values& parameters) const {
  if (robot_.flies()) {
    return robot_.name() + " flies; avoid_obstacle is for robots on the ground";
  }
  const std::size_t numbers = parameters.Get<skill::Numbers>("goal_pos", {}).size();
  if (numbers == 1 || numbers > 3) {
    return fmt::format("goal_pos has {}; expected 2 or 3: x, y and z in the map",
                       Counted(numbers, "number"));
  }
  const double speed = parameters.Number("speed");
  if (speed <= 0 || speed > kFastestMPerS) {
    return fmt::format("speed is {:g} m/s; expected more than 0 and at most {:g} m/s", speed,
                       kFastestMPerS);
  }
  for (const char* name : {"distance", "blocked_limit"}) {
    const double number = parameters.Number(name);
    if (number <= 0) return fmt::format("{} is {:g}; expected more than 0", name, number);
  }
  return std::nullopt;
}

std::optional<std::string> AvoidObstacle::Missing() const {
  if (!robot_.HasScan()) return "No scan of " + robot_.name();
  const auto pose = robot_.pose();
  if (!pose || !navigation::IsFinite(*pose)) return robot_.WhyNoPose();
  return std::nullopt;
}

Next AvoidObstacle::Step(Tick& tick) {
  if (tick.state == stopping_) return Stop(tick, "Reached goal");
  if (const auto why = WhyRefused(tick.parameters)) return Next::Fail(*why);
  return tick.state == initializing_ ? Initialize(tick) : Execute(tick);
}

Next AvoidObstacle::Initialize(Tick& tick) {
  tick.Report(5, "Waiting for the scan");
  if (Missing()) return Next::Stay();
  tick.data.Set(kBeginYaw, robot_.odometry().value_or(*robot_.pose()).yaw_rad);
  return Next::To(executing_);
}

AvoidObstacle::Aim AvoidObstacle::AimOf(Tick& tick, const navigation::Pose& pose) {
  const auto goal = tick.parameters.Get<skill::Numbers>("goal_pos", {});
  if (!goal.empty()) {
    const double x = goal[0] - pose.at.x_m, y = goal[1] - pose.at.y_m;
    return {std::hypot(x, y) - kArrivedM, navigation::Wrapped(std::atan2(y, x) - pose.yaw_rad)};
  }
  const double heading = tick.data.Number(kBeginYaw) + tick.parameters.Number("heading");
  const navigation::Point way = WaySince(last_, robot_);
  const double gone_m =
      tick.data.Number(kGone) + way.x_m * std::cos(heading) + way.y_m * std::sin(heading);
  tick.data.Set(kGone, gone_m);
  const double yaw_rad = robot_.odometry().value_or(pose).yaw_rad;
  return {tick.parameters.Number("distance") - gone_m, navigation::Wrapped(heading - yaw_rad)};
}

Next AvoidObstacle::Execute(Tick& tick) {
  if (const auto missing = Missing()) {
    robot_.SetVelocity({});
    blind_ += tick.step;
    tick.Report(0, *missing);
    return blind_ >= kLostAfter ? Next::Fail(*missing) : Next::Stay();
  }
  blind_ = {};
  const navigation::Pose pose = *robot_.pose();
  const Aim aim = AimOf(tick, pose);
  if (aim.left_m <= 0) return Complete(tick);
  constexpr double kNearerM = 0.1;
  const bool nearer = !nearest_m_ || aim.left_m < *nearest_m_ - kNearerM;
  if (nearer) nearest_m_ = aim.left_m;
  without_progress_ = nearer ? Duration{} : without_progress_ + tick.step;

  const std::vector<navigation::Point> around = SeenAround(robot_, pose, kLookedM);
  FieldRules rules{.radius_m = robot_.radius_m()};
  rules.range_m = std::min(kLookedM, aim.left_m + 2 * rules.radius_m + rules.margin_m);
  const auto direction = FreeDirection(around, aim.wanted_rad, direction_rad_, rules);
  const std::string held = robot_.HeldBy();
  blocked_ = direction && held.empty() ? Duration{} : blocked_ + tick.step;
  direction_rad_ = direction.value_or(0);
  const double free_m = FreeAhead(around, rules.radius_m, kKeptM, kLookedM);
  constexpr double kTurnsRadPerS = 1, kByAngle = 2;
  const double along = std::max(std::cos(2 * std::clamp(direction_rad_, -M_PI_4, M_PI_4)), 0.0);
  navigation::Velocity command;
  if (direction) {
    command.yaw_rad_s = std::clamp(kByAngle * direction_rad_, -kTurnsRadPerS, kTurnsRadPerS);
    command.x_m_s = along * std::min(tick.parameters.Number("speed"), SafeSpeed(free_m));
  }
  robot_.SetVelocity(command);

  const double limit_s = tick.parameters.Number("blocked_limit");
  if (ToSeconds(blocked_) >= limit_s) {
    return Next::Fail(fmt::format("Blocked: {} for {:.1f} s",
                                  held.empty() ? "no free direction" : held + ",", limit_s));
  }
  if (without_progress_ >= kProgressLimit) {
    return Next::Fail(fmt::format("Blocked: not nearer to the goal for {:.1f} s, {} m are left",
                                  ToSeconds(kProgressLimit), LengthText(aim.left_m)));
  }
  tick.Detail("distance_to_goal", aim.left_m);
  tick.Detail("current_velocity", navigation::Speed(robot_.velocity()));
  tick.Detail("free_ahead", free_m);
  tick.Report(10 + 85 / (1 + aim.left_m),
              blocked_ == Duration{} ? fmt::format("Moving... ({:.1f}s)", ToSeconds(tick.elapsed))
                                     : fmt::format("Blocked ({:.1f}s)", ToSeconds(blocked_)));
  return Next::Stay();
}

Next AvoidObstacle::OnLimit(Tick& tick) {
  if (tick.state == initializing_) return Next::Fail(Missing().value_or("No scan"));
  return Next::Fail("Timeout: " + LengthText(nearest_m_.value_or(0)) + " m are left");
}

}  // namespace musher::skills
