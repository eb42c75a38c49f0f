#pragma once
// The robots, objects and movers of a world in its picture: their places and ways in the top view,
// their rows in the legend, and their batteries over time.

#include <functional>

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// A point of the place on the canvas.
using ToPixel = std::function<Pixel(const Eigen::Vector2d&)>;

// Below the bodies: the ways of movers, the planned paths, and the ways that robots have driven.
void DrawFleetWays(const World& world, const ToPixel& at, Canvas& canvas);
// `scale`: pixels in a metre.
void DrawFleet(const World& world, const ToPixel& at, double scale, Canvas& canvas);

// Downwards from `at`; returns where the next row begins.
Pixel DrawFleetLegend(const World& world, const Pixel& at, Canvas& canvas);

}  // namespace musher::world
