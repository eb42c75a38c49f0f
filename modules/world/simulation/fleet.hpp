#pragma once
// The robots of a scene that are driven by velocity, the objects that they can hold, and the
// movers between them; moved step by step as a part of the world.
//
// A robot never gets into the fence, a fixed thing, a loose object, a mover or another robot: it
// stops, and the collision is counted once until it has moved 5 cm away. A mover waits for robots
// and objects in its way. An object stands on what is below it, or is held by one hand; a held one
// collides with nothing.
//
// A plain value: time and scene come in as arguments; the same seed and commands give the same.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/modules/world/body/battery.hpp"
#include "musher/modules/world/body/robot_body.hpp"
#include "musher/modules/world/scene/scene.hpp"
#include "musher/modules/world/scene/solids.hpp"
#include "musher/modules/world/simulation/mover.hpp"
#include "musher/modules/world/simulation/track.hpp"

namespace musher::world {

struct FleetRobot {
  RobotBody body;
  Battery battery;
  std::optional<std::size_t> holds;  // an object
  int collisions = 0;
  bool touching = false;                  // it has not moved away since the last collision
  Eigen::Vector3d stopped_at_m{0, 0, 0};  // by that collision
  double driven_m = 0;                    // length of its way, climbs included
  Track track;
  std::vector<Eigen::Vector2d> planned_m;  // the last path that was planned for it; drawn only
};

struct FleetObject {
  Eigen::Vector3d middle_m{0, 0, 0};
  double yaw_rad = 0;
  std::optional<std::size_t> held_by;  // a robot
  double yaw_in_hand_rad = 0;          // from the robot's yaw
};

enum class HandAction { kCheckDistance, kAttach, kRelease, kPlace };

struct HandRequest {
  HandAction action = HandAction::kCheckDistance;
  std::string object;                 // empty: the held one, of kRelease and kPlace
  double distance_threshold_m = 0;    // of the first two; 0: only the hand's reach counts
  Eigen::Vector3d target_m{0, 0, 0};  // of kPlace: the middle of the object's underside
};

struct HandReply {
  bool success = false;
  std::string message;
  double distance_m = -1;  // from the hand to the object, of kPlace to the target; -1: not known
};

class Fleet {
 public:
  // Loose objects fall to what is below them.
  explicit Fleet(const Scene& scene);

  // Each Step() and request gets the scene with the same robots, objects and movers. `others` are
  // further bodies in the way. Returns lines for the log.
  std::vector<std::string> Step(const Scene& scene, const std::vector<Solid>& others, Duration now,
                                Duration dt);

  // Returns the reason when it is refused.
  std::optional<std::string> Command(std::size_t robot, const BodyVelocity& command, Duration now);
  HandReply UseHand(const Scene& scene, std::size_t robot, const HandRequest& request);
  std::optional<std::string> SetBattery(const Scene& scene, std::size_t robot, double percent);
  // Onto the ground, standing still.
  std::optional<std::string> PutDown(const Scene& scene, const std::vector<Solid>& others,
                                     std::size_t robot, const Pose2& at, Duration now);
  void SetPlanned(std::size_t robot, std::vector<Eigen::Vector2d> points_m);

  // As the scene lists them.
  const std::vector<FleetRobot>& robots() const { return robots_; }
  const std::vector<FleetObject>& objects() const { return objects_; }
  const std::vector<Mover>& movers() const { return movers_; }

  // Objects, movers, and robots except one, without what that one holds.
  std::vector<Solid> MovingSolids(const Scene& scene, std::optional<std::size_t> without_robot,
                                  bool with_held_objects = true) const;

 private:
  // What a robot can collide with in a step.
  struct Around {
    const std::vector<Solid>& fixed;
    const std::vector<Solid>& moving;
  };

  void StepMovers(const Scene& scene, Duration dt);
  void StepRobot(const Scene& scene, std::size_t index, const Around& around, Duration now,
                 Duration dt, std::vector<std::string>& log);
  void Carry(const Scene& scene);
  void Record(std::size_t robot, Duration now);
  Eigen::Vector3d HandOf(const Scene& scene, std::size_t robot) const;
  std::optional<std::string> Between(const Scene& scene, std::size_t robot,
                                     const Eigen::Vector3d& to_m) const;
  void DropToSupport(const Scene& scene, std::size_t object);
  std::vector<Solid> Supports(const Scene& scene, std::size_t without_object) const;

  HandReply Attach(const Scene& scene, std::size_t robot, std::size_t object, double distance_m);
  HandReply Release(const Scene& scene, std::size_t robot, std::size_t object);
  HandReply Place(const Scene& scene, std::size_t robot, std::size_t object,
                  const Eigen::Vector3d& target_m);

  std::vector<FleetRobot> robots_;
  std::vector<FleetObject> objects_;
  std::vector<Mover> movers_;
};

// The cylinder of a robot at its position.
BodyCylinder CylinderOf(const RobotSpec& spec, const Eigen::Vector3d& feet_m);
Solid SolidOf(const ObjectSpec& spec, const FleetObject& object);
Solid SolidOf(const MoverSpec& spec, const Mover& mover);
Solid SolidOf(const RobotSpec& spec, const RobotBody& body);

}  // namespace musher::world
