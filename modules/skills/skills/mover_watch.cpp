#include "musher/modules/skills/skills/mover_watch.hpp"

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

constexpr Duration kLookEvery = Milliseconds(500);
constexpr Duration kLooksKept = std::chrono::seconds(8);
constexpr Duration kLately = std::chrono::seconds(1);  // before it, a place has to be free
constexpr double kLooksWithinM = 3;                    // farther away a scan has few points
constexpr double kSamePlaceM = 0.2;

double Away(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

// Of a point from the straight line to `to`; only what is before `to` can hide it.
bool Hides(const navigation::Point& point, const navigation::Point& from,
           const navigation::Point& to) {
  const double x = to.x_m - from.x_m, y = to.y_m - from.y_m, length_m = std::hypot(x, y);
  if (length_m <= 0) return false;
  const double dx = point.x_m - from.x_m, dy = point.y_m - from.y_m;
  const double along_m = (dx * x + dy * y) / length_m;
  return along_m > 0 && along_m < length_m && std::abs(dx * y - dy * x) / length_m < kSamePlaceM;
}

}  // namespace

void MoverWatch::Note(const Robot& robot, Duration step) {
  now_ += step;
  if (!looks_.empty() && now_ - looks_.back().at < kLookEvery) return;
  const auto pose = robot.pose();
  if (!pose || !navigation::IsFinite(*pose) || !robot.HasScan()) return;
  Look look{now_, *pose, {}};
  for (const navigation::Point& point : robot.obstacles()) {
    if (Away(point, pose->at) < kLooksWithinM + kSamePlaceM) look.seen.push_back(point);
  }
  looks_.push_back(std::move(look));
  while (now_ - looks_.front().at > kLooksKept) looks_.pop_front();
}

bool MoverWatch::WasFree(const Robot& robot, const Look& look,
                         const navigation::Point& place) const {
  if (now_ - look.at < kLately || Away(place, look.from.at) > kLooksWithinM) return false;
  const double c = std::cos(look.from.yaw_rad), s = std::sin(look.from.yaw_rad);
  const double x = place.x_m - look.from.at.x_m, y = place.y_m - look.from.at.y_m;
  if (!robot.ScanCovers({c * x + s * y, c * y - s * x, 0})) return false;
  return std::ranges::none_of(look.seen, [&](const navigation::Point& point) {
    return Away(point, place) < kSamePlaceM || Hides(point, look.from.at, place);
  });
}

bool MoverWatch::HaveCome(const Robot& robot, const std::vector<navigation::Point>& points) const {
  const auto come = std::ranges::count_if(points, [&](const navigation::Point& place) {
    return std::ranges::any_of(looks_,
                               [&](const Look& look) { return WasFree(robot, look, place); });
  });
  return come > 0 && 2 * come >= static_cast<std::ptrdiff_t>(points.size());
}

}  // namespace musher::skills
