#include "musher/test/navigation/maps.hpp"

#include <algorithm>

namespace musher::navigation::testing {

CellMap Drawn(const std::vector<std::string>& lines, double size_m, int cells) {
  CellMap map;
  map.resolution_m = size_m / cells;
  map.size_x = static_cast<int>(lines[0].size()) * cells;
  map.size_y = static_cast<int>(lines.size()) * cells;
  for (int y = map.size_y - 1; y >= 0; --y) {
    for (int x = 0; x < map.size_x; ++x) map.blocked.push_back(lines[y / cells][x / cells] == '#');
  }
  return map;
}

CellMap RandomBoxes(std::uint64_t seed, double size_m, double resolution_m, double share) {
  std::mt19937_64 random(seed);
  CellMap map;
  map.resolution_m = resolution_m;
  map.size_x = map.size_y = static_cast<int>(size_m / resolution_m);
  map.blocked.resize(static_cast<std::size_t>(map.size_x) * map.size_y);
  const auto wanted = static_cast<std::size_t>(share * static_cast<double>(map.count()));
  std::size_t blocked = 0;
  while (blocked < wanted) {
    const auto sample = [&](int below) { return static_cast<int>(random() % below); };
    const int size_x = 3 + sample(18), size_y = 3 + sample(18);
    const int begin_x = sample(map.size_x), begin_y = sample(map.size_y);
    for (int y = begin_y; y < std::min(begin_y + size_y, map.size_y); ++y) {
      for (int x = begin_x; x < std::min(begin_x + size_x, map.size_x); ++x) {
        std::uint8_t& cell = map.blocked[map.IndexOf({x, y, 0})];
        blocked += cell == 0;
        cell = 1;
      }
    }
  }
  return map;
}

CellMap Carved(double size_x_m, double size_y_m, double resolution_m,
               const std::vector<Rectangle>& free) {
  CellMap map;
  map.resolution_m = resolution_m;
  map.size_x = static_cast<int>(std::lround(size_x_m / resolution_m));
  map.size_y = static_cast<int>(std::lround(size_y_m / resolution_m));
  map.blocked.assign(static_cast<std::size_t>(map.size_x) * map.size_y, 1);
  for (std::size_t i = 0; i < map.blocked.size(); ++i) {
    const Point at = map.CentreOf(map.CellAt(i));
    for (const Rectangle& part : free) {
      const bool inside =
          at.x_m > part.x_m && at.x_m < part.to_x_m && at.y_m > part.y_m && at.y_m < part.to_y_m;
      if (inside) map.blocked[i] = 0;
    }
  }
  return map;
}

CellMap CorridorWithABay(double bay_m) {
  return Carved(14, 3, 0.05,
                {{0.2, 0.2, 2.7, 2.8},
                 {2.7, 1, 11.3, 1.8},
                 {11.3, 0.2, 13.8, 2.8},
                 {bay_m - 0.5, 1.8, bay_m + 0.5, 2.8}});
}

Point FreePlace(const Clearance& clearance, double radius_m, std::mt19937_64& random) {
  for (;;) {
    const Point place =
        clearance.map().CentreOf(clearance.map().CellAt(random() % clearance.map().count()));
    if (clearance.Fits(place, radius_m)) return place;
  }
}

}  // namespace musher::navigation::testing
