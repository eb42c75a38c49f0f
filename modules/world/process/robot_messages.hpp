#pragma once
// Converts the robots, objects and movers of a world to messages, and their commands back. Input
// is validated.

#include "musher/base/result.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/manipulation.hpp"
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

BodyVelocity FromMessage(const msg::Twist& twist);
// Fails for an unknown action.
Result<HandRequest> FromMessage(const msg::ManipulationControl::Request& request);

}  // namespace musher::world
