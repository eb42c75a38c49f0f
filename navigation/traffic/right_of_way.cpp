#include "musher/navigation/traffic/right_of_way.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musher::navigation {
namespace {

constexpr double kSampleM = 0.2;
constexpr double kOpposite = -0.3;     // the cosine of two directions: more than 107 degrees
constexpr double kThroughBodyM = 2;    // so far ahead a path through a body counts
constexpr double kSearchedAheadM = 3;  // of a path, for the place of its robot
constexpr double kSameM = 1e-3;

// A place of a path, with the direction in which the robot comes to it and how far it is.
struct Sample {
  Point at;
  double x = 0;  // of the direction, of length 1
  double y = 0;
  double ahead_m = 0;
};

double GapOf(const Point& a, const Point& b, bool flat) {
  return flat ? std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) : Distance(a, b);
}

std::vector<Sample> SamplesOf(const RobotIntent& robot, double most_m) {
  std::vector<Sample> samples;
  double ahead_m = 0;
  Point from = robot.at;
  for (const Point& to : robot.path) {
    const double length_m = std::hypot(to.x_m - from.x_m, to.y_m - from.y_m);
    if (length_m < kSameM) {
      from = to;
      continue;
    }
    const double x = (to.x_m - from.x_m) / length_m, y = (to.y_m - from.y_m) / length_m;
    for (double along_m = 0; along_m < length_m; along_m += kSampleM) {
      if (ahead_m + along_m > most_m) return samples;
      samples.push_back({Between(from, to, along_m / length_m), x, y, ahead_m + along_m});
    }
    ahead_m += length_m;
    from = to;
    if (ahead_m <= most_m) samples.push_back({to, x, y, ahead_m});
  }
  return samples;
}

bool LeadsThrough(const std::vector<Sample>& path, const Point& body, double keep_m, bool flat) {
  return std::ranges::any_of(path, [&](const Sample& sample) {
    return sample.ahead_m <= kThroughBodyM && GapOf(sample.at, body, flat) < keep_m;
  });
}

}  // namespace

double KeptApart(double radius_m, double other_radius_m, const MeetingRules& rules) {
  return radius_m + other_radius_m + rules.margin_m;
}

bool GoesFirst(const RobotIntent& a, const RobotIntent& b) {
  if (a.cornered != b.cornered) return a.cornered;
  if (a.priority != b.priority) return a.priority > b.priority;
  return a.robot < b.robot;
}

std::optional<Point> MeetingOf(const RobotIntent& own, const RobotIntent& other,
                               const MeetingRules& rules) {
  if (own.path.empty() || other.path.empty()) return std::nullopt;
  const bool flat = !own.flies && !other.flies;
  const double keep_m = KeptApart(own.radius_m, other.radius_m, rules);
  const double reach_m = rules.look_m + keep_m;
  if (GapOf(own.at, other.at, flat) > reach_m) return std::nullopt;
  const std::vector<Sample> ours = SamplesOf(own, rules.look_m);
  const std::vector<Sample> theirs = SamplesOf(other, rules.look_m);
  for (const Sample& mine : ours) {
    for (const Sample& its : theirs) {
      if (mine.ahead_m + its.ahead_m > rules.look_m) break;
      const bool opposite = mine.x * its.x + mine.y * its.y < kOpposite;
      if (opposite && GapOf(mine.at, its.at, flat) < keep_m) return mine.at;
    }
  }
  const bool through =
      LeadsThrough(ours, other.at, keep_m, flat) && LeadsThrough(theirs, own.at, keep_m, flat);
  if (through) return Between(own.at, other.at, 0.5);
  return std::nullopt;
}

RightOfWay RightOfWayOf(const RobotIntent& own, const std::vector<RobotIntent>& others,
                        const MeetingRules& rules) {
  RightOfWay right;
  for (const RobotIntent& other : others) {
    if (!MeetingOf(own, other, rules)) continue;
    right.meets = true;
    if (GoesFirst(other, own)) right.first.push_back(&other);
  }
  return right;
}

void PathLeft::Start(const Path& path) {
  points_.clear();
  passed_ = 0;
  passed_m_ = 0;
  for (const Pose& pose : path) points_.push_back(pose.at);
}

std::vector<Point> PathLeft::From(const Point& at) {
  double least_m = std::numeric_limits<double>::infinity(), searched_m = -passed_m_;
  std::size_t next = passed_ + 1;
  for (std::size_t i = passed_ + 1; i < points_.size() && searched_m < kSearchedAheadM; ++i) {
    const Point &from = points_[i - 1], &to = points_[i];
    const double x = to.x_m - from.x_m, y = to.y_m - from.y_m;
    const double square = x * x + y * y;
    const double along = (at.x_m - from.x_m) * x + (at.y_m - from.y_m) * y;
    const double share = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
    const double away_m = GapOf(Between(from, to, share), at, true);
    searched_m += std::sqrt(square);
    if (away_m >= least_m - kSameM) continue;
    least_m = away_m;
    next = share < 1 ? i : i + 1;
    passed_ = i - 1;
    passed_m_ = share * std::sqrt(square);
  }
  if (next < points_.size()) {
    return {points_.begin() + static_cast<std::ptrdiff_t>(next), points_.end()};
  }
  return points_.empty() ? std::vector<Point>{} : std::vector<Point>{points_.back()};
}

}  // namespace musher::navigation
