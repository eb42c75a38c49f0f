// The hands of a fleet and the objects that they hold.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "musher/base/suggest.hpp"
#include "musher/modules/world/simulation/fleet.hpp"
#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

HandReply Refused(const std::string& message, double distance_m = -1) {
  return {false, message, distance_m};
}

std::string Quoted(const std::string& name) {
  return "\"" + name.substr(0, 60) + "\"";
}

std::string UnknownObject(const Scene& scene, const std::string& name) {
  std::vector<std::string> names;
  for (const ObjectSpec& spec : scene.objects) names.push_back(spec.name);
  if (names.empty()) return "the scene has no objects";
  return "there is no object " + Quoted(name) + DidYouMean(name.substr(0, 60), names, "\"\"");
}

}  // namespace

Vector3d Fleet::HandOf(const Scene& scene, std::size_t robot) const {
  const RobotBody& body = robots_[robot].body;
  Vector3d hand = scene.robots[robot].hand->position_m;
  hand.head<2>() = Rotation2Dd(body.yaw_rad()) * Vector2d(hand.head<2>());
  return body.position_m() + hand;
}

// What is higher than the hand and crosses the straight way from the middle of the robot to its
// hand, and from there to a place: an arm reaches over low things, and not through a wall.
std::optional<std::string> Fleet::Between(const Scene& scene, std::size_t robot,
                                          const Vector3d& to_m) const {
  constexpr double kStepM = 0.02;  // a wall is thicker
  const Vector3d hand_m = HandOf(scene, robot);
  const Vector3d body_m = robots_[robot].body.position_m();
  std::vector<Vector3d> way = {{body_m.x(), body_m.y(), hand_m.z()}, hand_m, to_m};
  for (const Solid& solid : SolidsOf(scene)) {
    if (TopOf(solid) < hand_m.z()) continue;
    for (std::size_t i = 1; i < way.size(); ++i) {
      const Vector3d along = way[i] - way[i - 1];
      const int steps = static_cast<int>(std::ceil(along.norm() / kStepM));
      for (int k = 0; k <= steps; ++k) {
        const Vector3d at = way[i - 1] + along * (steps == 0 ? 0 : double(k) / steps);
        const bool inside = DistanceTo(solid, at.head<2>()) < 0 && at.z() > BottomOf(solid);
        if (inside && at.z() < TopOf(solid)) return solid.what;
      }
    }
  }
  return std::nullopt;
}

// What an object can stand on, or stand in.
std::vector<Solid> Fleet::Supports(const Scene& scene, std::size_t without_object) const {
  std::vector<Solid> solids = SolidsOf(scene);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (i == without_object || objects_[i].held_by) continue;
    solids.push_back(SolidOf(scene.objects[i], objects_[i]));
  }
  return solids;
}

void Fleet::Settle(const Scene& scene, std::size_t index) {
  FleetObject& object = objects_[index];
  const BodyCylinder core = CoreOf(SolidOf(scene.objects[index], object));
  const double height = scene.objects[index].size_m.z();
  object.middle_m.z() = FloorBelow(Supports(scene, index), core) + height / 2;
}

HandReply Fleet::UseHand(const Scene& scene, std::size_t robot, const HandRequest& request) {
  const RobotSpec& spec = scene.robots.at(robot);
  if (!spec.hand) return Refused(spec.name + " has no hand");
  const bool puts = request.action == HandAction::kRelease || request.action == HandAction::kPlace;
  std::optional<std::size_t> object;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (scene.objects[i].name == request.object) object = i;
  }
  if (puts && request.object.empty()) object = robots_[robot].holds;
  if (!object && request.object.empty()) {
    return Refused(puts ? spec.name + " holds no object" : "expected the name of an object");
  }
  if (!object) return Refused(UnknownObject(scene, request.object));
  const double distance_m = (objects_[*object].middle_m - HandOf(scene, robot)).norm();
  if (puts) {
    if (objects_[*object].held_by != robot) {
      return Refused(spec.name + " does not hold " + scene.objects[*object].name, distance_m);
    }
    return request.action == HandAction::kRelease ? Release(scene, robot, *object)
                                                  : Place(scene, robot, *object, request.target_m);
  }
  const double threshold_m = request.distance_threshold_m;
  if (!std::isfinite(threshold_m) || threshold_m < 0) {
    return Refused("expected a distance threshold of 0 m or more, found " + NumberText(threshold_m),
                   distance_m);
  }
  const double reach_m = spec.hand->reach_m;
  const double limit_m = threshold_m > 0 ? std::min(threshold_m, reach_m) : reach_m;
  if (distance_m > limit_m) {
    return Refused("Too far: " + MetresText(distance_m) + "m > " + MetresText(limit_m) + "m" +
                       (limit_m < threshold_m ? " (the reach of the hand)" : ""),
                   distance_m);
  }
  if (const auto wall = Between(scene, robot, objects_[*object].middle_m)) {
    return Refused(*wall + " is between the hand and " + scene.objects[*object].name, distance_m);
  }
  if (request.action == HandAction::kAttach) return Attach(scene, robot, *object, distance_m);
  return {true, "Within grasp distance", distance_m};
}

HandReply Fleet::Attach(const Scene& scene, std::size_t robot, std::size_t index,
                        double distance_m) {
  FleetObject& object = objects_[index];
  const std::string& name = scene.objects[index].name;
  if (object.held_by == robot) return {true, "Object attached", distance_m};
  if (object.held_by) {
    return Refused(name + " is held by " + scene.robots[*object.held_by].name, distance_m);
  }
  if (const auto held = robots_[robot].holds) {
    return Refused(scene.robots[robot].name + " already holds " + scene.objects[*held].name,
                   distance_m);
  }
  object.held_by = robot;
  object.yaw_in_hand_rad = object.yaw_rad - robots_[robot].body.yaw_rad();
  robots_[robot].holds = index;
  Carry(scene);
  // What stood on it falls.
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (i != index && !objects_[i].held_by) Settle(scene, i);
  }
  return {true, "Object attached", distance_m};
}

HandReply Fleet::Release(const Scene& scene, std::size_t robot, std::size_t index) {
  const BodyCylinder core = CoreOf(SolidOf(scene.objects[index], objects_[index]));
  for (const Solid& solid : Supports(scene, index)) {
    if (Overlaps(solid, core)) return Refused("the hand is in " + solid.what + "; move it first");
  }
  objects_[index].held_by.reset();
  robots_[robot].holds.reset();
  Settle(scene, index);
  return {true, "Object released", (objects_[index].middle_m - HandOf(scene, robot)).norm()};
}

HandReply Fleet::Place(const Scene& scene, std::size_t robot, std::size_t index,
                       const Vector3d& target_m) {
  if (!target_m.allFinite()) return Refused("a target that is not a number is refused");
  const ObjectSpec& spec = scene.objects[index];
  FleetObject there = objects_[index];
  there.middle_m = target_m + Vector3d(0, 0, spec.size_m.z() / 2);
  const double distance_m = (there.middle_m - HandOf(scene, robot)).norm();
  const double reach_m = scene.robots[robot].hand->reach_m;
  if (distance_m > reach_m) {
    return Refused("Too far: " + MetresText(distance_m) + "m > " + MetresText(reach_m) +
                       "m (the reach of the hand)",
                   distance_m);
  }
  const BodyCylinder core = CoreOf(SolidOf(spec, there));
  if (target_m.z() < -kStandingInM || !IsWithin(scene, core)) {
    return Refused("the target is outside the place", distance_m);
  }
  BodyCylinder raised = core;  // a target may be a little too low
  raised.feet_m.z() += kStandingInM;
  std::vector<Solid> solids = Supports(scene, index);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    solids.push_back(SolidOf(scene.robots[i], robots_[i].body));
  }
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    solids.push_back(SolidOf(scene.movers[i], movers_[i]));
  }
  for (const Solid& solid : solids) {
    if (Overlaps(solid, raised)) {
      return Refused("the target is in " + solid.what, distance_m);
    }
  }
  if (const auto wall = Between(scene, robot, there.middle_m)) {
    return Refused(*wall + " is between the hand and the target", distance_m);
  }
  there.held_by.reset();
  objects_[index] = there;
  robots_[robot].holds.reset();
  Settle(scene, index);
  return {true, "Object placed", distance_m};
}

}  // namespace musher::world
