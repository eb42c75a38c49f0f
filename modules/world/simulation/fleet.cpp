#include "musher/modules/world/simulation/fleet.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kApartM = 0.05;      // so far from a collision, the next one counts
constexpr double kMoverKeepsM = 0.1;  // from what is in its way

// A seed of its own for each thing of a scene.
std::uint64_t SeedOf(const Scene& scene, std::uint64_t kind, std::size_t index) {
  transport::sim::Random of_scene(scene.seed);
  transport::sim::Random of_kind(of_scene.Next() + kind);
  return transport::sim::Random(of_kind.Next() + index).Next();
}

constexpr std::uint64_t kGusts = 101;
constexpr std::uint64_t kMovers = 102;

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

BodyCylinder CylinderOf(const RobotSpec& spec, const Vector3d& feet_m) {
  return {feet_m, spec.radius_m, spec.height_m};
}

Solid SolidOf(const ObjectSpec& spec, const FleetObject& object) {
  const double bottom_m = object.middle_m.z() - spec.size_m.z() / 2;
  const Vector2d middle = object.middle_m.head<2>();
  if (spec.round) {
    return {spec.name,
            Circle{spec.name, middle, spec.size_m.x() / 2, spec.size_m.z(), bottom_m, spec.color}};
  }
  return {spec.name, Box{spec.name, middle, spec.size_m.head<2>() / 2, object.yaw_rad,
                         spec.size_m.z(), bottom_m, spec.color}};
}

Solid SolidOf(const MoverSpec& spec, const Mover& mover) {
  return {spec.name,
          Circle{spec.name, mover.position_m(), spec.radius_m, spec.height_m, 0, spec.color}};
}

Solid SolidOf(const RobotSpec& spec, const RobotBody& body) {
  return {spec.name, Circle{spec.name, body.position_m().head<2>(), spec.radius_m, spec.height_m,
                            body.position_m().z(), spec.color}};
}

Fleet::Fleet(const Scene& scene) {
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const RobotSpec& spec = scene.robots[i];
    robots_.push_back({.body = RobotBody(spec, SeedOf(scene, kGusts, i)),
                       .battery = Battery(spec.battery),
                       .holds = std::nullopt,
                       .track = {},
                       .planned_m = {}});
    Record(i, {});
  }
  for (const ObjectSpec& spec : scene.objects) {
    objects_.push_back({spec.middle_m, spec.yaw_rad, std::nullopt, 0});
  }
  for (std::size_t i = 0; i < objects_.size(); ++i) DropToSupport(scene, i);
  for (std::size_t i = 0; i < scene.movers.size(); ++i) {
    movers_.emplace_back(scene.movers[i], SeedOf(scene, kMovers, i));
  }
}

std::vector<std::string> Fleet::Step(const Scene& scene, const std::vector<Solid>& others,
                                     Duration now, Duration dt) {
  std::vector<std::string> log;
  if (robots_.empty() && movers_.empty()) return log;
  StepMovers(scene, dt);
  const std::vector<Solid> fixed = SolidsOf(scene);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    std::vector<Solid> around = MovingSolids(scene, i, false);
    around.insert(around.end(), others.begin(), others.end());
    StepRobot(scene, i, {fixed, around}, now, dt, log);
  }
  Carry(scene);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i].track.IsDue(now)) Record(i, now);
  }
  return log;
}

void Fleet::StepMovers(const Scene& scene, Duration dt) {
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const MoverSpec& spec = scene.movers[i];
    const Vector2d from = movers_[i].position_m();
    const auto blocks = [&](const Solid& solid, const Vector2d& to) {
      if (BottomOf(solid) >= spec.height_m) return false;
      const double far = DistanceTo(solid, to) - spec.radius_m;
      return far < kMoverKeepsM && far < DistanceTo(solid, from) - spec.radius_m;
    };
    const auto is_free = [&](const Vector2d& to) {
      for (std::size_t r = 0; r < robots_.size(); ++r) {
        if (blocks(SolidOf(scene.robots[r], robots_[r].body), to)) return false;
      }
      for (std::size_t o = 0; o < objects_.size(); ++o) {
        if (!objects_[o].held_by && blocks(SolidOf(scene.objects[o], objects_[o]), to)) {
          return false;
        }
      }
      return true;
    };
    movers_[i].Step(spec, is_free, dt);
  }
}

void Fleet::StepRobot(const Scene& scene, std::size_t index, const Around& around, Duration now,
                      Duration dt, std::vector<std::string>& log) {
  FleetRobot& robot = robots_[index];
  const RobotSpec& spec = scene.robots[index];
  const auto in_the_way = [&](const Vector3d& from, const Vector3d& to) {
    const BodyCylinder body = CylinderOf(spec, from);
    if (FenceBlocks(scene, body, to)) return std::optional<std::string>("the edge of the place");
    for (const auto* solids : {&around.fixed, &around.moving}) {
      for (const Solid& solid : *solids) {
        if (Blocks(solid, body, to)) return std::optional<std::string>(solid.what);
      }
    }
    return std::optional<std::string>();
  };
  const auto floor = [&](const Vector3d& at) {
    return FloorBelow(around.fixed, CylinderOf(spec, at));
  };
  const bool was_empty = robot.battery.empty();
  const Activity activity = robot.body.moving() ? Activity::kMoving : Activity::kStanding;
  const bool on_pad = !robot.body.airborne() && IsOnPad(scene, robot.body.position_m().head<2>());
  robot.battery.Step(dt, activity, on_pad);
  if (robot.battery.empty() && !was_empty) {
    log.push_back(spec.name + ": the battery is empty" +
                  (robot.body.airborne() ? "; it sinks to the ground" : ""));
  }
  const Vector3d from = robot.body.position_m();
  robot.body.Step({in_the_way, floor}, robot.battery.empty(), now, dt);
  robot.driven_m += (robot.body.position_m() - from).norm();
  const std::string& stopped_by = robot.body.stopped_by();
  if (!stopped_by.empty() && !robot.touching) {
    ++robot.collisions;
    robot.touching = true;
    robot.stopped_at_m = robot.body.position_m();
    const Vector2d where = robot.body.position_m().head<2>();
    robot.track.AddBump({now, where});
    log.push_back(spec.name + " collided with " + stopped_by + " at " + PointText(where));
  }
  const double gone_m = (robot.body.position_m() - robot.stopped_at_m).norm();
  if (gone_m > kApartM) robot.touching = false;
}

void Fleet::Carry(const Scene& scene) {
  for (FleetObject& object : objects_) {
    if (!object.held_by) continue;
    object.middle_m = HandOf(scene, *object.held_by);
    object.yaw_rad =
        std::remainder(robots_[*object.held_by].body.yaw_rad() + object.yaw_in_hand_rad, 2 * M_PI);
  }
}

void Fleet::Record(std::size_t index, Duration now) {
  FleetRobot& robot = robots_[index];
  Sample sample;
  sample.at = now;
  sample.pose = {robot.body.position_m().head<2>(), robot.body.yaw_rad()};
  sample.battery_percent = robot.battery.percent();
  sample.charging = robot.battery.charging();
  robot.track.Add(sample, "", "");
}

std::optional<std::string> Fleet::Command(std::size_t robot, const BodyVelocity& command,
                                          Duration now) {
  return robots_.at(robot).body.Take(command, now);
}

std::optional<std::string> Fleet::SetBattery(const Scene& scene, std::size_t robot,
                                             double percent) {
  if (!(percent >= 0 && percent <= 100)) {
    return scene.robots.at(robot).name + ": a battery of " + NumberText(percent) +
           " % is refused: expected 0 to 100";
  }
  robots_.at(robot).battery.Set(percent);
  return std::nullopt;
}

std::optional<std::string> Fleet::PutDown(const Scene& scene, const std::vector<Solid>& others,
                                          std::size_t index, const Pose2& at, Duration now) {
  const RobotSpec& spec = scene.robots.at(index);
  if (!at.position_m.allFinite() || !std::isfinite(at.yaw_rad)) {
    return spec.name + ": a place that is not a number is refused";
  }
  const Vector3d feet(at.position_m.x(), at.position_m.y(), 0);
  const BodyCylinder body = CylinderOf(spec, feet);
  std::vector<Solid> solids = SolidsOf(scene);
  solids.insert(solids.end(), others.begin(), others.end());
  const std::vector<Solid> moving = MovingSolids(scene, index, false);
  solids.insert(solids.end(), moving.begin(), moving.end());
  const std::string refused = spec.name + " cannot be at " + PointText(at.position_m) + ": ";
  if (!IsWithin(scene, body)) return refused + "it is outside the place";
  for (const Solid& solid : solids) {
    if (Overlaps(solid, body)) return refused + "it would be in " + solid.what;
  }
  Record(index, now);
  robots_[index].body.PutDown(feet, at.yaw_rad);
  Record(index, now);
  Carry(scene);
  return std::nullopt;
}

void Fleet::SetPlanned(std::size_t robot, std::vector<Vector2d> points_m) {
  robots_.at(robot).planned_m = std::move(points_m);
}

std::vector<Solid> Fleet::MovingSolids(const Scene& scene, std::optional<std::size_t> without_robot,
                                       bool with_held_objects) const {
  std::vector<Solid> solids;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const FleetObject& object = objects_[i];
    const bool shown = !object.held_by || (with_held_objects && object.held_by != without_robot);
    if (shown) solids.push_back(SolidOf(scene.objects[i], object));
  }
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    solids.push_back(SolidOf(scene.movers[i], movers_[i]));
  }
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    if (i != without_robot) solids.push_back(SolidOf(scene.robots[i], robots_[i].body));
  }
  return solids;
}

// --- the hands of the robots and the objects that they hold ---

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

void Fleet::DropToSupport(const Scene& scene, std::size_t index) {
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
    if (i != index && !objects_[i].held_by) DropToSupport(scene, i);
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
  DropToSupport(scene, index);
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
  DropToSupport(scene, index);
  return {true, "Object placed", distance_m};
}

}  // namespace musher::world
