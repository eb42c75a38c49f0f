#pragma once
// A competition field in the picture of a world: its platforms and boxes, the way of its robot with
// climbs, fetches and faults, and its height over time. Nothing is drawn without a field.
//
// Threads: any; pure but for the canvas.

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/picture/fleet_view.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// `scale`: pixels in a metre.
void DrawField(const World& world, const ToPixel& at, double scale, Canvas& canvas);

// Downwards from `at`; returns where the next row begins.
Pixel DrawFieldLegend(const World& world, const Pixel& at, Canvas& canvas);

// The height of the robot's underside, and that of the ground below its middle, over world time.
void DrawHeightChart(const World& world, const Pixel& corner, const Pixel& opposite,
                     Canvas& canvas);

}  // namespace musher::world
