#pragma once
// Reads the robots, objects and movers of a scene, and checks that they can be where they are.

#include "musher/base/toml/rows.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// [battery], and that of a robot.
config_toml::Rows BatteryRows(BatterySpec& battery);

// [[robot]], [[object]] and [[mover]]. Call it when the obstacles are read: places are checked.
void ReadRobots(config_toml::TableReader& root, config_toml::Findings& findings, Scene& scene);

}  // namespace musher::world
