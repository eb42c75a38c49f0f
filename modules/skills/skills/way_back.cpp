#include "musher/modules/skills/skills/way_back.hpp"

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

constexpr double kTinyM = 0.03;  // the direction of less is noise
constexpr double kLookAheadM = 0.15;
constexpr double kLeastBendM = 0.1;   // nearer places bend the way no more than this far one
constexpr std::size_t kAtOnce = 4;    // places that it may pass in one step
constexpr double kMostTurnRad = 1.3;  // from the heading at the begin: below a quarter

double LevelApart(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// In the frame of a body.
navigation::Point SeenFrom(const navigation::Pose& body, const navigation::Point& place) {
  const double x = place.x_m - body.at.x_m, y = place.y_m - body.at.y_m;
  const double c = std::cos(body.yaw_rad), s = std::sin(body.yaw_rad);
  return {c * x + s * y, c * y - s * x, 0};
}

}  // namespace

WayBack::WayBack(const navigation::Pose& here, const navigation::Path& travelled, double most_m)
    : begin_rad_(here.yaw_rad), places_{{here.at}} {
  for (std::size_t i = 0; i < travelled.size() && length_m() < most_m; ++i) {
    const navigation::Point from = places_.back().at, to = travelled[i].at;
    const double step_m = LevelApart(from, to);
    if (step_m < kTinyM) continue;
    const double ahead_rad = std::atan2(from.y_m - to.y_m, from.x_m - to.x_m);
    const bool came_ahead =
        std::abs(navigation::Wrapped(travelled[i].yaw_rad - ahead_rad)) < M_PI / 2;
    const bool behind = std::abs(navigation::Wrapped(begin_rad_ - ahead_rad)) < kMostBendRad;
    if (!came_ahead || !behind) return;
    const double left_m = most_m - length_m();
    places_.push_back({navigation::Between(from, to, std::min(1.0, left_m / step_m)),
                       length_m() + std::min(step_m, left_m)});
  }
}

std::size_t WayBack::NextOf(std::size_t place, double ahead_m) const {
  std::size_t next = place;
  while (next + 1 < places_.size() && places_[next].along_m < places_[place].along_m + ahead_m) {
    ++next;
  }
  return next;
}

navigation::Velocity WayBack::Command(const navigation::Pose& body, const Speeds& speeds) {
  std::size_t nearest = passed_;
  for (std::size_t i = passed_; i < std::min(passed_ + kAtOnce + 1, places_.size()); ++i) {
    if (LevelApart(body.at, places_[i].at) <= LevelApart(body.at, places_[nearest].at)) nearest = i;
  }
  passed_ = nearest;
  if (over()) return {};
  const navigation::Point to = SeenFrom(body, places_[NextOf(passed_, kLookAheadM)].at);
  lost_ = to.x_m >= 0 || std::abs(std::atan2(to.y_m, -to.x_m)) > kMostTurnRad ||
          std::abs(navigation::Wrapped(body.yaw_rad - begin_rad_)) > kMostTurnRad;
  if (lost_) return {};
  // On the arc through that place.
  const double away_m = std::max(std::hypot(to.x_m, to.y_m), kLeastBendM);
  const double turn_rad_s = -speeds.m_s * 2 * to.y_m / (away_m * away_m);
  const double share = std::min(1.0, speeds.rad_s / std::max(std::abs(turn_rad_s), 1e-9));
  return {.x_m_s = -speeds.m_s * share, .yaw_rad_s = turn_rad_s * share};
}

std::vector<navigation::Pose> WayBack::Left(const navigation::Pose& body) const {
  std::vector<navigation::Pose> left{{}};
  for (std::size_t i = passed_ + 1; i < places_.size(); ++i) {
    const navigation::Point at = SeenFrom(body, places_[i].at), from = left.back().at;
    if (LevelApart(at, from) < kTinyM) continue;
    left.back().yaw_rad = std::atan2(at.y_m - from.y_m, at.x_m - from.x_m);
    left.push_back({at, left.back().yaw_rad});
  }
  return left;
}

}  // namespace musher::skills
