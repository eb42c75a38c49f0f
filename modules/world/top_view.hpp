#pragma once
// A place seen from above, with the way the body took.

#include "musher/modules/world/canvas.hpp"
#include "musher/modules/world/world.hpp"

namespace musher::world {

inline constexpr double kMapAxis = 34;  // so high is the axis below the place

// Draws the place as large as it fits between the corners, at their left, with its axes outside to
// the left of it and within below it. Gives where it ends to the right.
double DrawTopView(const World& world, const Pixel& corner, const Pixel& opposite, Canvas& canvas);

void DrawLegend(const World& world, const Pixel& corner, Canvas& canvas);

}  // namespace musher::world
