#include "musher/navigation/traffic/known_robots.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr double kLargestRadiusM = 20;

}  // namespace

Result<> KnownRobots::Take(RobotIntent intent, Duration stamp, Time now) {
  if (intent.robot.empty()) return MakeError(Fault::kInput, "a robot without a name");
  if (intent.robot == own_) return Ok();
  const bool has_size = intent.radius_m >= 0 && intent.radius_m <= kLargestRadiusM;
  const bool finite = IsFinite(intent.at) &&
                      std::ranges::all_of(intent.path, [](const Point& p) { return IsFinite(p); });
  if (!has_size || !finite || intent.path.size() > kMostPoints) {
    return MakeError(Fault::kInput, "the path of " + intent.robot.substr(0, 80) +
                                        " has a number that is not finite or out of range");
  }
  const auto found = known_.find(intent.robot);
  if (found != known_.end()) {
    const bool lives = now - found->second.at <= kStale;
    const bool newer = stamp > found->second.stamp;
    const bool clock_was_set = !lives && stamp < found->second.stamp;
    if (!newer && !clock_was_set) return Ok();
  } else if (known_.size() >= kMost) {
    known_.erase(
        std::ranges::min_element(known_, {}, [](const auto& named) { return named.second.at; }));
  }
  std::string name = intent.robot;
  known_.insert_or_assign(std::move(name), Known{std::move(intent), stamp, now});
  return Ok();
}

std::vector<RobotIntent> KnownRobots::At(Time now) const {
  std::vector<RobotIntent> robots;
  for (const auto& [name, known] : known_) {
    if (now - known.at <= kStale) robots.push_back(known.intent);
  }
  return robots;
}

}  // namespace musher::navigation
