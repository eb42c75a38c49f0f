#include "musher/modules/world/scene/place.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr double kTouchingM = 1e-9;  // rounding
constexpr int kSlides = 4;           // out of this many things at once, as in a corner

double BottomOf(const Ball& ball) {
  return ball.shown ? ball.center_m.z() - ball.radius_m : HUGE_VAL;
}
template <class Thing>
double BottomOf(const Thing& thing) {
  return thing.bottom_m;
}

// Calls `visit` with every obstacle for a body of that height.
template <class Visit>
void EachObstacle(const Scene& scene, double height_m, Visit visit) {
  const auto all = [&](const auto& things) {
    for (const auto& thing : things) {
      if (BottomOf(thing) < height_m) visit(thing);
    }
  };
  all(scene.boxes);
  all(scene.circles);
  all(scene.boards);
  all(scene.balls);
}

// Moves `point` out of all obstacles; returns whether one was in its way.
bool PushOut(const Scene& scene, Vector2d& point) {
  bool touched = false;
  const double radius = scene.body.radius_m;
  EachObstacle(scene, scene.body.stand_height_m, [&](const auto& obstacle) {
    const Clearance clearance = From(obstacle, point);
    if (clearance.distance_m >= radius) return;
    point += clearance.away * (radius - clearance.distance_m);
    touched = true;
  });
  const Vector2d inside = point.cwiseMax(scene.least_m + Vector2d::Constant(radius))
                              .cwiseMin(scene.most_m - Vector2d::Constant(radius));
  touched = touched || inside != point;
  point = inside;
  return touched;
}

}  // namespace

Clearance From(const Box& box, const Vector2d& point_m) {
  const Rotation2Dd turn(box.yaw_rad);
  const Vector2d local = turn.inverse() * (point_m - box.center_m);
  const Vector2d beyond = local.cwiseAbs() - box.half_m;
  const Vector2d sign(local.x() < 0 ? -1 : 1, local.y() < 0 ? -1 : 1);
  if (beyond.maxCoeff() > 0) {
    const Vector2d gap = beyond.cwiseMax(0);
    return {gap.norm(), turn * gap.normalized().cwiseProduct(sign)};
  }
  const Vector2d out = beyond.x() > beyond.y() ? Vector2d::UnitX() : Vector2d::UnitY();
  return {beyond.maxCoeff(), turn * out.cwiseProduct(sign)};
}

Clearance From(const Circle& circle, const Vector2d& point_m) {
  const Vector2d gap = point_m - circle.center_m;
  const double distance = gap.norm();
  const Vector2d away = distance > 0 ? Vector2d(gap / distance) : Vector2d::UnitX();
  return {distance - circle.radius_m, away};
}

Clearance From(const Board& board, const Vector2d& point_m) {
  constexpr double kThicknessM = 0.01;
  return From(Box{"", board.center_m, {kThicknessM / 2, board.width_m / 2}, board.yaw_rad},
              point_m);
}

Clearance From(const Ball& ball, const Vector2d& point_m) {
  return From(Circle{"", ball.center_m.head<2>(), ball.radius_m}, point_m);
}

bool IsFree(const Scene& scene, const Vector2d& point_m) {
  return IsFree(scene, point_m, scene.body.radius_m, scene.body.stand_height_m);
}

bool IsFree(const Scene& scene, const Vector2d& point_m, double radius_m, double height_m) {
  const double radius = radius_m - kTouchingM;
  const Vector2d margin = Vector2d::Constant(radius);
  if ((point_m - scene.least_m - margin).minCoeff() < 0) return false;
  if ((scene.most_m - point_m - margin).minCoeff() < 0) return false;
  bool clear = true;
  EachObstacle(scene, height_m, [&](const auto& obstacle) {
    clear = clear && From(obstacle, point_m).distance_m >= radius;
  });
  return clear;
}

Step2 Go(const Scene& scene, const Vector2d& from_m, const Vector2d& to_m) {
  Step2 step{to_m, false};
  for (int i = 0; i < kSlides && PushOut(scene, step.to_m); ++i) step.bumped = true;
  if (step.bumped && !IsFree(scene, step.to_m)) step.to_m = from_m;
  return step;
}

bool IsOnPad(const Scene& scene, const Vector2d& point_m) {
  return std::any_of(scene.pads.begin(), scene.pads.end(), [&](const Pad& pad) {
    return (point_m - pad.center_m).cwiseAbs().maxCoeff() <= pad.size_m / 2;
  });
}

}  // namespace musher::world
