#pragma once
// Which sign a detector of gestures would report of what the front camera sees: the world plays the
// detector, since there is none yet. A function of the world alone.

#include "musher/modules/world/world.hpp"

namespace musher::world {

inline constexpr double kFarthestGestureM = 5;

// Of the nearest guest that makes a sign, looks at the robot and has its head in the picture with
// nothing of the place before it.
Gesture SeenGesture(const World& world);

}  // namespace musher::world
