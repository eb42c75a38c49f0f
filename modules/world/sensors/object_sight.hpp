#pragma once
// Which objects a robot has in sight: those of which at least one point is hidden by nothing else.
// A function of the world alone.
//
// The eye is the robot's camera; without one, the middle of its upper side. It looks in all
// directions and has no limit of distance: what a camera's picture shows is for others to say.

#include <cstddef>
#include <vector>

#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// In the sequence of the scene.
std::vector<std::size_t> ObjectsInSight(const World& world, std::size_t robot);

// An object that the detector of a robot has found, in the frame of the robot.
struct DetectedObject {
  std::size_t object = 0;  // of the scene
  Eigen::Vector3d middle_m{0, 0, 0};
  double yaw_rad = 0;
};

// What the detector of a robot finds in one picture: the objects in sight that are in its view,
// with its noise, without those that it misses. Random numbers depend on the seed, the robot and
// the time. The robot has a detector.
std::vector<DetectedObject> DetectObjects(const World& world, std::size_t robot);

}  // namespace musher::world
