#include "musher/modules/world/sensors/ranging.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The part of a ray inside a solid; empty when it leaves before it enters.
struct Span {
  double enter_m = 0;
  double leave_m = kNothing;

  bool empty() const { return enter_m > leave_m; }
};

// Removes from `span` what is not between two parallel planes.
void Cut(Span& span, double from, double along, double least, double most) {
  if (along == 0) {
    if (from < least || from > most) span.leave_m = -1;
    return;
  }
  const auto [enter, leave] = std::minmax({(least - from) / along, (most - from) / along});
  span.enter_m = std::max(span.enter_m, enter);
  span.leave_m = std::min(span.leave_m, leave);
}

// Removes from `span` what is not in a ball, or with two coordinates in an upright tube, around 0.
template <class Vector>
void CutRound(Span& span, const Vector& from, const Vector& along, double radius) {
  const double a = along.squaredNorm();
  const double outside = from.squaredNorm() - radius * radius;
  if (a == 0) {
    if (outside > 0) span.leave_m = -1;
    return;
  }
  const double b = from.dot(along);
  const double root = b * b - a * outside;
  if (root < 0) {
    span.leave_m = -1;
    return;
  }
  span.enter_m = std::max(span.enter_m, (-b - std::sqrt(root)) / a);
  span.leave_m = std::min(span.leave_m, (-b + std::sqrt(root)) / a);
}

}  // namespace

RayTargets::RayTargets(const Scene& scene, const Vector3d& from_m, double most_m)
    : from_m_(from_m),
      most_m_(most_m),
      least_place_m_(scene.least_m),
      most_place_m_(scene.most_m),
      fence_height_m_(scene.fence_height_m) {
  for (const Box& box : scene.boxes) {
    Add(box.center_m, box.yaw_rad, box.half_m, box.bottom_m, box.height_m, 0);
  }
  for (const Circle& circle : scene.circles) {
    Add(circle.center_m, 0, {0, 0}, circle.bottom_m, circle.height_m, circle.radius_m);
  }
  for (const Board& board : scene.boards) {
    Add(board.center_m, board.yaw_rad, {0, board.width_m / 2}, board.bottom_m, board.height_m, 0,
        board.round);
  }
  for (const Ball& ball : scene.balls) {
    if (!ball.shown) continue;
    const Vector3d from = from_m - ball.center_m;
    if (from.norm() <= most_m + ball.radius_m) rounds_.push_back({from, ball.radius_m});
  }
}

void RayTargets::Add(const Vector2d& center_m, double yaw_rad, const Vector2d& half_m,
                     double bottom_m, double height_m, double radius_m, bool round) {
  const Vector2d from = from_m_.head<2>() - center_m;
  if (from.norm() > most_m_ + half_m.norm() + radius_m) return;
  Solid solid;
  solid.cos_yaw = std::cos(yaw_rad);
  solid.sin_yaw = std::sin(yaw_rad);
  solid.from_m = {solid.cos_yaw * from.x() + solid.sin_yaw * from.y(),
                  solid.cos_yaw * from.y() - solid.sin_yaw * from.x(), from_m_.z()};
  solid.least_m = {-half_m.x(), -half_m.y(), bottom_m};
  solid.most_m = {half_m.x(), half_m.y(), bottom_m + height_m};
  solid.radius_m = radius_m;
  solid.round = round;
  solids_.push_back(solid);
}

double RayTargets::DistanceAlong(const Vector3d& along) const {
  if (from_m_.z() <= 0) return 0;  // in the ground
  double nearest = ToFence(along);
  if (along.z() < 0) nearest = std::min(nearest, -from_m_.z() / along.z());
  for (const Solid& solid : solids_) {
    const Vector2d turned(solid.cos_yaw * along.x() + solid.sin_yaw * along.y(),
                          solid.cos_yaw * along.y() - solid.sin_yaw * along.x());
    Span span;
    Cut(span, solid.from_m.z(), along.z(), solid.least_m.z(), solid.most_m.z());
    if (solid.radius_m > 0) {
      CutRound<Vector2d>(span, solid.from_m.head<2>(), turned, solid.radius_m);
    } else {
      Cut(span, solid.from_m.x(), turned.x(), solid.least_m.x(), solid.most_m.x());
      Cut(span, solid.from_m.y(), turned.y(), solid.least_m.y(), solid.most_m.y());
    }
    if (span.empty()) continue;
    if (solid.round && !IsOnDisc(solid, turned.y(), along.z(), span.enter_m)) continue;
    nearest = std::min(nearest, span.enter_m);
  }
  for (const Round& round : rounds_) {
    Span span;
    CutRound<Vector3d>(span, round.from_m, along, round.radius_m);
    if (!span.empty()) nearest = std::min(nearest, span.enter_m);
  }
  if (nearest > most_m_) return kNothing;
  return nearest;
}

bool RayTargets::IsOnDisc(const Solid& board, double along_y, double along_z, double distance_m) {
  const Vector3d half = (board.most_m - board.least_m) / 2;
  const Vector3d middle = (board.most_m + board.least_m) / 2;
  const double aside = (board.from_m.y() + distance_m * along_y - middle.y()) / half.y();
  const double up = (board.from_m.z() + distance_m * along_z - middle.z()) / half.z();
  return aside * aside + up * up <= 1;
}

double RayTargets::ToFence(const Vector3d& along) const {
  constexpr double kRounding = 1e-9;  // m: a ray to a corner meets one side or the other
  double nearest = kNothing;
  for (const int axis : {0, 1}) {
    if (along[axis] == 0) continue;
    const double side = along[axis] > 0 ? most_place_m_[axis] : least_place_m_[axis];
    const double distance = (side - from_m_[axis]) / along[axis];
    const double height = from_m_.z() + distance * along.z();
    const double aside = from_m_[1 - axis] + distance * along[1 - axis];  // not beyond a corner
    if (distance >= 0 && height >= 0 && height <= fence_height_m_ &&
        aside >= least_place_m_[1 - axis] - kRounding &&
        aside <= most_place_m_[1 - axis] + kRounding) {
      nearest = std::min(nearest, distance);
    }
  }
  return nearest;
}

double DistanceAlong(const Scene& scene, const Vector3d& from_m, const Vector3d& along,
                     double most_m) {
  return RayTargets(scene, from_m, most_m).DistanceAlong(along);
}

}  // namespace musher::world
