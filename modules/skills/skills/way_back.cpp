#include "musher/modules/skills/skills/way_back.hpp"

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

constexpr double kTinyM = 0.01;
constexpr double kWayEndM = 0.03;  // so near to its end it is over
constexpr double kLookAheadM = 0.15;
constexpr double kLeastBendM = 0.1;  // nearer places bend the way no more than this far one
constexpr std::size_t kAtOnce = 4;   // places that it may pass in one step
constexpr double kGoesAheadRad = 1;  // else it goes there backwards
constexpr double kTurnFromRad = 0.6, kTurnToRad = 0.15;
constexpr double kBackTurnGainPerS = 2;

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
    : places_{{here.at}} {
  for (std::size_t i = 0; i < travelled.size() && length_m() < most_m; ++i) {
    const navigation::Point from = places_.back().at, to = travelled[i].at;
    const double step_m = LevelApart(from, to);
    if (step_m < kTinyM) continue;
    const double left_m = most_m - length_m();
    places_.push_back({navigation::Between(from, to, std::min(1.0, left_m / step_m)),
                       length_m() + std::min(step_m, left_m)});
  }
}

bool WayBack::over() const {
  return passed_m() >= length_m() - kWayEndM;
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
  if (!turning_) ahead_ = std::abs(std::atan2(to.y_m, to.x_m)) < kGoesAheadRad;
  const double sign = ahead_ ? 1 : -1;
  const double off_rad = std::atan2(sign * to.y_m, sign * to.x_m);
  turning_ = std::abs(off_rad) > (turning_ ? kTurnToRad : kTurnFromRad);
  if (turning_) {
    return {.yaw_rad_s = std::clamp(kBackTurnGainPerS * off_rad, -speeds.rad_s, speeds.rad_s)};
  }
  // On the arc through that place.
  const double away_m = std::max(std::hypot(to.x_m, to.y_m), kLeastBendM);
  const double bend = 2 * to.y_m / (away_m * away_m);
  const double turn_rad_s = sign * speeds.m_s * bend;
  const double share = std::min(1.0, speeds.rad_s / std::max(std::abs(turn_rad_s), 1e-9));
  return {.x_m_s = sign * speeds.m_s * share, .yaw_rad_s = turn_rad_s * share};
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
