#pragma once
// Converts the robots, objects and movers of a world to messages, and their commands back. Input
// is validated.

#include <Eigen/Core>
#include <string>

#include "musher/base/result.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// The pose in the map, the velocity in the frame of the robot, or of the mover.
msg::Odometry OdometryOfRobot(const World& world, std::size_t robot);
msg::Odometry OdometryOfMover(const World& world, std::size_t mover);

msg::BatteryState ToBatteryState(const Battery& battery, const BatterySpec& spec, Duration at);

// All objects; the pose is of the middle.
msg::ObjectStates ToObjectStates(const World& world);
// Those that the robot has in sight.
msg::ObjectStates ObjectsInSightOf(const World& world, std::size_t robot);
// Those that its detector finds, in the frame of the robot. It has one.
msg::ObjectStates DetectionsOf(const World& world, std::size_t robot);

// Where the lines of the scene are in the view of the robot, without an error. It has one.
msg::YellowLines LinesInView(const World& world, std::size_t robot);

BodyVelocity FromMessage(const msg::Twist& twist);

// What is wrong with the odometry of a robot.
struct OdometryFault {
  bool freezes = false;         // the pose stands, its stamps do not
  Eigen::Vector2d off_m{0, 0};  // added to the pose
};
// "freeze", "jump X Y", in m, or "right". Fails for anything else.
Result<OdometryFault> OdometryFaultFrom(const std::string& text);

// Fails for an unknown action.
Result<HandRequest> FromMessage(const msg::ManipulationControl::Request& request);

}  // namespace musher::world
