#include "musher/modules/world/simulation/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
namespace {

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
  for (std::size_t i = 0; i < objects_.size(); ++i) Settle(scene, i);
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

}  // namespace musher::world
