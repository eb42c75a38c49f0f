#pragma once
// Pictures side by side, each labelled with its time.
//
// Reentrant.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"

namespace musher::camera::tool {

struct StripTile {
  msg::Image picture;  // bgr8
  std::string label;
};

// The picture as a tile of that width, in its own proportions.
Result<msg::Image> TileOf(msg::Image picture, std::uint32_t width_px);

// Tiles of several cameras as one, from left to right; a missing one stays white.
msg::Image SideBySide(const std::vector<std::optional<msg::Image>>& tiles);

// bgr8. In rows of `columns`, all cells as large as the largest tile; empty without tiles.
msg::Image DrawStrip(const std::vector<StripTile>& tiles, int columns);

// When a picture was taken: the world's time as it is, a date's relative to the first picture.
std::string LabelOf(std::int64_t stamp_ns, std::int64_t first_ns);

}  // namespace musher::camera::tool
