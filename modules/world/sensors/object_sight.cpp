#include "musher/modules/world/sensors/object_sight.hpp"

#include <Eigen/Geometry>

#include "musher/modules/world/sensors/fleet_sensing.hpp"
#include "musher/modules/world/sensors/ranging.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInsetShare = 0.8;  // the tested points are within the object, near its corners
constexpr double kSameM = 1e-6;

Vector3d EyeOf(const World& world, std::size_t robot) {
  const RobotSpec& spec = world.scene().robots[robot];
  const RobotBody& body = world.fleet().robots()[robot].body;
  Vector3d mount = spec.camera ? spec.camera->position_m : Vector3d(0, 0, spec.height_m);
  mount.head<2>() = Rotation2Dd(body.yaw_rad()) * Vector2d(mount.head<2>());
  return body.position_m() + mount;
}

// The middle of an object and its corners, a little inwards.
std::vector<Vector3d> PointsOf(const ObjectSpec& spec, const FleetObject& object) {
  std::vector<Vector3d> points{object.middle_m};
  const Vector3d half = kInsetShare / 2 * spec.size_m;
  const double sides[] = {-1, 1};
  for (const double x : sides) {
    for (const double y : sides) {
      // The corners of the square in the circle of a round one.
      const Vector2d flat =
          spec.round ? Vector2d(x, y) * half.x() * M_SQRT1_2 : Vector2d(x * half.x(), y * half.y());
      const Vector2d turned = Rotation2Dd(object.yaw_rad) * flat;
      for (const double z : sides) {
        points.emplace_back(object.middle_m + Vector3d(turned.x(), turned.y(), z * half.z()));
      }
    }
  }
  return points;
}

// Whether a ray from `eye` meets the object before anything of `around`.
bool IsInSight(const Scene& around, const ObjectSpec& spec, const FleetObject& object,
               const Vector3d& eye) {
  const double most_m = (object.middle_m - eye).norm() + spec.size_m.norm();
  Scene alone;
  const Solid solid = SolidOf(spec, object);
  if (const auto* box = std::get_if<Box>(&solid.shape)) alone.boxes = {*box};
  if (const auto* circle = std::get_if<Circle>(&solid.shape)) alone.circles = {*circle};
  alone.fence_height_m = 0;
  const RayTargets of_object(alone, eye, most_m);
  const RayTargets of_all(around, eye, most_m);
  for (const Vector3d& point : PointsOf(spec, object)) {
    const Vector3d ray = point - eye;
    if (ray.norm() < kSameM) return true;
    const Vector3d along = ray.normalized();
    const double object_m = of_object.DistanceAlong(along);
    if (object_m < kNothing && object_m <= of_all.DistanceAlong(along) + kSameM) return true;
  }
  return false;
}

}  // namespace

std::vector<std::size_t> ObjectsInSight(const World& world, std::size_t robot) {
  const Scene around = SceneAround(world, robot);
  const Vector3d eye = EyeOf(world, robot);
  const auto& specs = world.scene().objects;
  std::vector<std::size_t> seen;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    if (IsInSight(around, specs[i], world.fleet().objects()[i], eye)) seen.push_back(i);
  }
  return seen;
}

}  // namespace musher::world
