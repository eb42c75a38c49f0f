#pragma once
// Battery, machine state and motion over world time.

#include "musher/modules/world/paint/canvas.hpp"
#include "musher/modules/world/simulation/track.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

inline constexpr double kChartNames = 84;  // width of the names left of its rows

// Into the rectangle between the corners, including names at the left and times below.
void DrawStripChart(const Track& track, const Pixel& corner, const Pixel& opposite, Canvas& canvas);

// The batteries of a fleet over world time, each in its colour.
void DrawBatteryChart(const World& world, const Pixel& corner, const Pixel& opposite,
                      Canvas& canvas);

// "1:05", from seconds of world time.
std::string ClockText(double seconds);

}  // namespace musher::world
