#include "musher/modules/world/sensors/object_sight.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "musher/modules/world/body/normal_random.hpp"
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

std::vector<DetectedObject> DetectObjects(const World& world, std::size_t robot) {
  constexpr std::uint64_t kDetector = 2000;
  const DetectorSpec& detector = *world.scene().robots.at(robot).detector;
  const RobotBody& body = world.fleet().robots()[robot].body;
  const Rotation2Dd to_body(-body.yaw_rad());
  const auto in_body = [&](Vector3d at) {
    at -= body.position_m();
    at.head<2>() = to_body * Vector2d(at.head<2>());
    return at;
  };
  const Vector3d eye = in_body(EyeOf(world, robot));
  transport::sim::Random seed(world.scene().seed);
  transport::sim::Random of_robot(seed.Next() + kDetector + robot);
  const std::uint64_t of_picture =
      of_robot.Next() + static_cast<std::uint64_t>(world.now().count());
  NormalRandom noise(of_picture);
  transport::sim::Random misses(of_picture + 1);
  std::vector<DetectedObject> found;
  for (const std::size_t i : ObjectsInSight(world, robot)) {
    const FleetObject& object = world.fleet().objects()[i];
    DetectedObject seen{i, in_body(object.middle_m), object.yaw_rad - body.yaw_rad()};
    const Vector3d from_eye = seen.middle_m - eye;
    const double bearing_rad = std::atan2(from_eye.y(), from_eye.x());
    const bool missed = misses.Bernoulli(detector.miss_share);
    const bool in_view =
        from_eye.norm() <= detector.most_m && std::abs(bearing_rad) <= detector.hfov_rad / 2;
    if (missed || !in_view) continue;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      seen.middle_m[axis] += detector.noise_m * noise.Normal();
    }
    found.push_back(seen);
  }
  return found;
}

}  // namespace musher::world
