#pragma once
// A place seen from above, with the path of the body.

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

inline constexpr double kMapAxis = 34;  // height of the axis below the place

// Draws the place as large as fits between the corners, at their left, with its axes to the left
// of it and below it inside. Returns its right edge.
double DrawTopView(const World& world, const Pixel& corner, const Pixel& opposite, Canvas& canvas);

}  // namespace musher::world
