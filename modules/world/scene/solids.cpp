#include "musher/modules/world/scene/solids.hpp"

#include <algorithm>
#include <cmath>

namespace musher::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kContactM = 1e-6;  // rounding
constexpr double kBoardM = 0.01;

std::string Named(const char* kind, const std::string& name) {
  return name.empty() ? std::string("a ") + kind : std::string(kind) + " \"" + name + "\"";
}

double Overhang(const Scene& scene, const Vector2d& point_m, double radius_m) {
  const Vector2d least = scene.least_m - point_m + Vector2d::Constant(radius_m);
  const Vector2d most = point_m - scene.most_m + Vector2d::Constant(radius_m);
  return std::max(least.maxCoeff(), most.maxCoeff());
}

double HeadRoom(const Scene& scene) {
  return scene.ceiling_m > 0 ? scene.ceiling_m : kHighestFlightM;
}

}  // namespace

std::vector<Solid> SolidsOf(const Scene& scene) {
  std::vector<Solid> solids;
  for (const Box& box : scene.boxes) {
    solids.push_back({box.name.empty() ? "a wall or box" : Named("box", box.name), box});
  }
  for (const Circle& circle : scene.circles) {
    solids.push_back({Named("circle", circle.name), circle});
  }
  for (const Board& board : scene.boards) {
    solids.push_back({Named("board", board.name), Box{board.name,
                                                      board.center_m,
                                                      {kBoardM / 2, board.width_m / 2},
                                                      board.yaw_rad,
                                                      board.height_m,
                                                      board.bottom_m,
                                                      {}}});
  }
  for (const Ball& ball : scene.balls) {
    if (!ball.shown) continue;
    solids.push_back({Named("ball", ball.name), Circle{ball.name,
                                                       ball.center_m.head<2>(),
                                                       ball.radius_m,
                                                       2 * ball.radius_m,
                                                       ball.center_m.z() - ball.radius_m,
                                                       {}}});
  }
  return solids;
}

double BottomOf(const Solid& solid) {
  return std::visit([](const auto& shape) { return shape.bottom_m; }, solid.shape);
}

double TopOf(const Solid& solid) {
  return std::visit([](const auto& shape) { return shape.bottom_m + shape.height_m; }, solid.shape);
}

double DistanceTo(const Solid& solid, const Vector2d& point_m) {
  return std::visit([&](const auto& shape) { return From(shape, point_m).distance_m; },
                    solid.shape);
}

BodyCylinder CoreOf(const Solid& solid) {
  const Vector2d middle = std::visit([](const auto& shape) { return shape.center_m; }, solid.shape);
  const auto* circle = std::get_if<Circle>(&solid.shape);
  const double radius_m =
      circle != nullptr ? circle->radius_m : std::get<Box>(solid.shape).half_m.minCoeff();
  const double bottom_m = BottomOf(solid);
  return {{middle.x(), middle.y(), bottom_m}, radius_m, TopOf(solid) - bottom_m};
}

bool Overlaps(const Solid& solid, const BodyCylinder& body) {
  const double bottom = body.feet_m.z();
  if (bottom + body.height_m <= BottomOf(solid) + kContactM) return false;
  if (bottom >= TopOf(solid) - kContactM) return false;
  return DistanceTo(solid, body.feet_m.head<2>()) < body.radius_m - kContactM;
}

bool Blocks(const Solid& solid, const BodyCylinder& body, const Vector3d& to_m) {
  if (!Overlaps(solid, {to_m, body.radius_m, body.height_m})) return false;
  if (!Overlaps(solid, body)) return true;
  return DistanceTo(solid, to_m.head<2>()) < DistanceTo(solid, body.feet_m.head<2>());
}

bool FenceBlocks(const Scene& scene, const BodyCylinder& body, const Vector3d& to_m) {
  const double out = Overhang(scene, to_m.head<2>(), body.radius_m);
  if (out > kContactM && out > Overhang(scene, body.feet_m.head<2>(), body.radius_m)) return true;
  return to_m.z() > body.feet_m.z() && to_m.z() + body.height_m > HeadRoom(scene) + kContactM;
}

bool IsWithin(const Scene& scene, const BodyCylinder& body) {
  return Overhang(scene, body.feet_m.head<2>(), body.radius_m) <= kContactM &&
         body.feet_m.z() + body.height_m <= HeadRoom(scene) + kContactM;
}

double FloorBelow(const std::vector<Solid>& solids, const BodyCylinder& body) {
  double floor_m = 0;
  for (const Solid& solid : solids) {
    const double top = TopOf(solid);
    if (top <= floor_m || top > body.feet_m.z() + kStandingInM) continue;
    if (DistanceTo(solid, body.feet_m.head<2>()) < body.radius_m - kContactM) floor_m = top;
  }
  return floor_m;
}

}  // namespace musher::world
