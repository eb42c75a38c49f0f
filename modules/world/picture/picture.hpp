#pragma once
// The picture of a world: seen from above with the path of the body, and below it battery, machine
// state and motion over world time.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

inline constexpr int kPictureWidth = 1200;
inline constexpr int kPictureHeight = 960;  // at most; less for a place that is wide

// Writes a PNG. Fails when the file cannot be written. From any thread; takes some 100 ms.
Result<> Draw(const World& world, const std::string& path);

}  // namespace musher::world
