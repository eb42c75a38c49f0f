#pragma once
// The gesture that a detector would report from the front camera: the world publishes it in place
// of a detector, since there is none yet. A function of the world alone.

#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

inline constexpr double kFarthestGestureM = 5;

// Of the nearest guest that makes a gesture, looks at the robot, and whose head is in the picture
// and not hidden by anything.
Gesture SeenGesture(const World& world);

}  // namespace musher::world
