#pragma once
// What the colours and shapes of a top view mean.

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// Downwards from `corner`; only what occurs in the view.
void DrawLegend(const World& world, const Pixel& corner, Canvas& canvas);

}  // namespace musher::world
