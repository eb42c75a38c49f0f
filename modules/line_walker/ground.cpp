#include "musher/modules/line_walker/ground.hpp"

#include <algorithm>

namespace musher::line_walker {

GroundPoints EdgeOnGround(const MountedCamera& camera, double trunk_height_m, double farthest_m,
                          const msg::YellowLines& lines, std::size_t most) {
  GroundPoints all;
  const std::size_t count = std::min(lines.edge_x.size(), lines.edge_y.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto point =
        OnGround(camera, trunk_height_m, farthest_m, lines.edge_x[i], lines.edge_y[i]);
    if (point) all.push_back(*point);
  }
  if (all.size() <= most) return all;
  GroundPoints chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(all[i * all.size() / most]);
  return chosen;
}

}  // namespace musher::line_walker
