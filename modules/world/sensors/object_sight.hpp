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

}  // namespace musher::world
