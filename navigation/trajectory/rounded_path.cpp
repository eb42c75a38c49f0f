#include "musher/navigation/trajectory/rounded_path.hpp"

#include <algorithm>
#include <cmath>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/trajectory/path_curve.hpp"

namespace musher::navigation {
namespace {

constexpr double kSharpestTurnRad = 2 * M_PI / 3;
constexpr double kLeastTurnRad = 0.01;  // less is straight on
constexpr double kPiecesOfCorner = 8;   // at least

double TurnBetween(const Point& a, const Point& b, const Point& c) {
  const double u[] = {b.x_m - a.x_m, b.y_m - a.y_m, b.z_m - a.z_m};
  const double v[] = {c.x_m - b.x_m, c.y_m - b.y_m, c.z_m - b.z_m};
  const double dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  return std::acos(std::clamp(dot / (Distance(a, b) * Distance(b, c)), -1.0, 1.0));
}

// Its corners with begin and end. Places between two corners do not count.
std::vector<Point> CornersOf(const Path& path) {
  std::vector<Point> corners;
  for (const Pose& pose : path) {
    if (!corners.empty() && Distance(corners.back(), pose.at) < 1e-6) continue;
    const std::size_t count = corners.size();
    if (count > 1 && TurnBetween(corners[count - 2], corners[count - 1], pose.at) < 1e-3) {
      corners.pop_back();
    }
    corners.push_back(pose.at);
  }
  return corners;
}

class RoundedPath {
 public:
  explicit RoundedPath(const RoundRules& rules) : rules_(rules) {}

  void LineTo(const Point& to) {
    if (points_.empty()) return points_.push_back(to);
    const Point from = points_.back();
    if (from == to) return;
    const int count =
        static_cast<int>(std::max(1.0, std::ceil(Distance(from, to) / rules_.step_m)));
    for (int i = 1; i <= count; ++i) {
      points_.push_back(Between(from, to, static_cast<double>(i) / count));
    }
  }
  // A parabola from before the corner to behind it. It leaves the corner by half of `before_m`,
  // times the sine of half of the turn.
  void Corner(const Point& a, const Point& corner, const Point& b) {
    const double turn_rad = TurnBetween(a, corner, b);
    if (turn_rad < kLeastTurnRad || turn_rad > kSharpestTurnRad) return LineTo(corner);
    const double to_m = Distance(a, corner), from_m = Distance(corner, b);
    const double cut_m =
        std::min({to_m / 2, from_m / 2, 2 * rules_.corner_m / std::sin(turn_rad / 2)});
    const Point begin = Between(corner, a, cut_m / to_m), end = Between(corner, b, cut_m / from_m);
    LineTo(begin);
    // An even number: a pose lies in the middle, where the curve is nearest to the corner.
    const int pieces =
        static_cast<int>(std::max(kPiecesOfCorner, 2 * std::ceil(cut_m / rules_.step_m)));
    for (int i = 1; i <= pieces; ++i) {
      const double share = static_cast<double>(i) / pieces;
      points_.push_back(Between(Between(begin, corner, share), Between(corner, end, share), share));
    }
  }
  Path Take(const Pose& first, const Pose& last) const {
    Path path{first};
    for (std::size_t i = 1; i + 1 < points_.size(); ++i) {
      const Point &before = points_[i - 1], &behind = points_[i + 1];
      const double yaw_rad = std::atan2(behind.y_m - before.y_m, behind.x_m - before.x_m);
      path.push_back({points_[i], yaw_rad});
    }
    if (points_.size() > 1) path.push_back(last);
    return path;
  }

 private:
  const RoundRules rules_;
  std::vector<Point> points_;
};

}  // namespace

Result<Path> RoundCorners(const Path& path, const RoundRules& rules) {
  if (path.empty()) return MakeError(Fault::kInput, "the path has no poses");
  double length_m = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!IsFinite(path[i])) {
      return MakeError(Fault::kInput, "the path has a number that is not finite");
    }
    if (i > 0) length_m += Distance(path[i - 1].at, path[i].at);
  }
  if (!(length_m <= kLongestPathM)) {
    return MakeError(Fault::kInput, "the path is longer than 10 km");
  }
  const std::vector<Point> corners = CornersOf(path);
  RoundedPath rounded(rules);
  rounded.LineTo(corners.front());
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    rounded.Corner(corners[i - 1], corners[i], corners[i + 1]);
  }
  rounded.LineTo(corners.back());
  return rounded.Take(path.front(), path.back());
}

}  // namespace musher::navigation
