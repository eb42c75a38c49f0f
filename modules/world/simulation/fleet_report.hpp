#pragma once
// What the robots of a scene do now: pose, battery, what they hold, collisions. Pure.

#include <string>

#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// A table with a line for each robot.
std::string FleetText(const World& world);

// {"name": scene, "time_s": t, "robots": [{"name", "kind", "x_m", "y_m", "z_m", "yaw_rad",
// "airborne", "battery_percent", "holds" (null: nothing), "collisions", "driven_m"}]}
std::string FleetJson(const World& world);

}  // namespace musher::world
