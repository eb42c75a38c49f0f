#include "musher/modules/skills/skills/move.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

// The way-points that are behind the robot, over all loops.
constexpr std::string_view kWayPointsDone = "waypoints_done";

std::int64_t DoneOf(const skill::Tick& tick) {
  return tick.data.Get<std::int64_t>(kWayPointsDone, 0);
}

}  // namespace

void Move::Describe(skill::Table& table) {
  table.Does("Goes from way-point to way-point of a path, in a loop");
  table.Uses(kBase);
  table.Needs("path", skill::Kind::kText, "way-points, m in the map: [[0, 0], [4, 0], [4, 3]]");
  table.Takes("loops", std::int64_t{0}, "times, 0: until it is cancelled");
  table.RefusesParameter("cancel", "to cancel the skill, cancel its goal");
  table.Limit({.run = skill::kNoLimit});
}

Result<> Move::Take(const skill::Tick& tick) {
  const auto refuse = [](std::string why) { return Error{kCodeParametersInvalid, std::move(why)}; };
  const auto path = ParsePoints("path", tick.parameters.Text("path"));
  if (!path) return path.error();
  path_ = path.value();
  loops_ = tick.parameters.Get<std::int64_t>("loops", 0);
  if (path_.empty()) return refuse("path has no way-points");
  if (loops_ < 0) return refuse(fmt::format("loops is {}; expected 0 or more", loops_));
  for (std::size_t i = 0; i < path_.size(); ++i) {
    if (!robot().flies()) path_[i].z_m = 0;
    const Result<> altitude =
        CheckAltitude(robot(), fmt::format("way-point {}", i + 1), path_[i].z_m);
    if (!altitude) return altitude.error();
  }
  const bool apart = std::ranges::any_of(
      path_, [&](const auto& point) { return navigation::Distance(point, path_[0]) > 0; });
  if (!apart && loops_ != 1) return refuse("path has one place; a loop needs at least two");
  return Ok();
}

navigation::Pose Move::Goal(const skill::Tick& tick) const {
  const auto pose = robot().pose().value_or(navigation::Pose());
  const auto& to = path_[static_cast<std::size_t>(DoneOf(tick)) % path_.size()];
  constexpr double kNearM = 0.1;
  if (std::hypot(to.x_m - pose.at.x_m, to.y_m - pose.at.y_m) < kNearM) return {to, pose.yaw_rad};
  return {to, std::atan2(to.y_m - pose.at.y_m, to.x_m - pose.at.x_m)};
}

std::optional<std::string> Move::OnArrival(skill::Tick& tick) {
  const std::int64_t done = DoneOf(tick) + 1;
  tick.data.Set(kWayPointsDone, done);
  const auto count = static_cast<std::int64_t>(path_.size());
  if (loops_ == 0 || done < loops_ * count) return std::nullopt;
  return fmt::format("Path completed ({} way-points, {} {})", count, loops_,
                     loops_ == 1 ? "loop" : "loops");
}

std::string Move::Prefix(const skill::Tick& tick) const {
  if (path_.empty()) return {};
  const auto count = static_cast<std::int64_t>(path_.size());
  return fmt::format("Way-point {} of {}: ", DoneOf(tick) % count + 1, count);
}

double Move::Share(skill::Tick& tick, double share) const {
  const auto count = static_cast<std::int64_t>(path_.size());
  const std::int64_t done = DoneOf(tick);
  tick.Detail("waypoint", done % count + 1);
  tick.Detail("loop", done / count + 1);
  const auto of_loop = static_cast<double>(done % count) + share;
  if (loops_ == 0) return of_loop / static_cast<double>(count);
  return (static_cast<double>(done) + share) / static_cast<double>(count * loops_);
}

}  // namespace musher::skills
