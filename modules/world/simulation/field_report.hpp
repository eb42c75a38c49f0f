#pragma once
// What a field's robot did and does now: pose, wheels, boxes, climbs, bumps and falls. Pure.

#include <string>

#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// One object; FIELD.md lists its keys. "{}" without a field.
std::string FieldJson(const World& world);

}  // namespace musher::world
