#include "musher/navigation/planner/cell_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

// An index that fits into an int for every coordinate, also for those that are not finite.
int FloorOf(double cells) {
  constexpr double kFar = 1e9;
  if (!(cells >= -kFar)) return static_cast<int>(-kFar);
  return static_cast<int>(std::floor(std::min(cells, kFar)));
}

Result<> CheckShape(double resolution_m, const Pose& origin, std::int64_t x, std::int64_t y,
                    std::int64_t z) {
  if (!std::isfinite(resolution_m) || resolution_m <= 0) {
    return MakeError(Fault::kMap,
                     fmt::format("map: resolution {} m, expected a positive number", resolution_m));
  }
  if (!IsFinite(origin)) {
    return MakeError(Fault::kMap, "map: its origin has a number that is not finite");
  }
  if (x < 1 || y < 1 || z < 1) {
    return MakeError(Fault::kMap, fmt::format("map: it is empty ({} x {} cells)", x, y));
  }
  if (x > kMostCells || y > kMostCells || z > kMostCells || x * y > kMostCells ||
      x * y * z > kMostCells) {
    return MakeError(Fault::kMap,
                     fmt::format("map: {} x {} x {} cells of {} m, at most {} in all; use a "
                                 "coarser resolution or a smaller part",
                                 x, y, z, resolution_m, kMostCells));
  }
  return Ok();
}

bool Counts(const Point& point, const CloudRules& rules) {
  return IsFinite(point) && point.z_m >= rules.from_z_m && point.z_m <= rules.to_z_m;
}

}  // namespace

Cell CellMap::CellAt(std::size_t index) const {
  const auto layer = static_cast<std::size_t>(size_x) * size_y;
  return {static_cast<int>(index % size_x), static_cast<int>(index % layer / size_x),
          static_cast<int>(index / layer)};
}

Point CellMap::InCells(const Point& point) const {
  const double c = std::cos(origin.yaw_rad), s = std::sin(origin.yaw_rad);
  const double x_m = point.x_m - origin.at.x_m, y_m = point.y_m - origin.at.y_m;
  return {(c * x_m + s * y_m) / resolution_m, (c * y_m - s * x_m) / resolution_m,
          flat() ? 0.5 : (point.z_m - origin.at.z_m) / resolution_m};
}

Cell CellMap::CellOf(const Point& point) const {
  const Point in_cells = InCells(point);
  return {FloorOf(in_cells.x_m), FloorOf(in_cells.y_m), FloorOf(in_cells.z_m)};
}

Point CellMap::CentreOf(const Cell& cell) const {
  const double c = std::cos(origin.yaw_rad), s = std::sin(origin.yaw_rad);
  const double x_m = (cell.x + 0.5) * resolution_m, y_m = (cell.y + 0.5) * resolution_m;
  return {origin.at.x_m + c * x_m - s * y_m, origin.at.y_m + s * x_m + c * y_m,
          origin.at.z_m + (flat() ? 0 : (cell.z + 0.5) * resolution_m)};
}

std::string CellMap::ExtentText() const {
  const auto range = [&](double from_m, int cells) {
    return fmt::format("{:.2f} to {:.2f} m", from_m, from_m + cells * resolution_m);
  };
  std::string text = "x " + range(origin.at.x_m, size_x) + ", y " + range(origin.at.y_m, size_y);
  if (!flat()) text += ", z " + range(origin.at.z_m, size_z);
  if (origin.yaw_rad != 0) text += fmt::format(", turned by {:.2f} rad", origin.yaw_rad);
  return text;
}

Result<> CheckCellMap(const CellMap& map) {
  auto shape = CheckShape(map.resolution_m, map.origin, map.size_x, map.size_y, map.size_z);
  if (!shape.ok()) return shape;
  const std::int64_t count = std::int64_t{map.size_x} * map.size_y * map.size_z;
  if (count != static_cast<std::int64_t>(map.count())) {
    return MakeError(Fault::kMap, fmt::format("map: {} cells, expected {} x {} x {}", map.count(),
                                              map.size_x, map.size_y, map.size_z));
  }
  return Ok();
}

Result<CellMap> FromOccupancyGrid(const OccupancyGrid& grid, const OccupancyRules& rules) {
  auto shape = CheckShape(grid.resolution_m, grid.origin, grid.width, grid.height, 1);
  if (!shape.ok()) return shape.error();
  if (grid.data.size() != std::size_t{grid.width} * grid.height) {
    return MakeError(Fault::kMap, fmt::format("occupancy grid: {} cells, expected {} x {}",
                                              grid.data.size(), grid.width, grid.height));
  }
  CellMap map{grid.resolution_m,
              grid.origin,
              static_cast<int>(grid.width),
              static_cast<int>(grid.height),
              1,
              std::vector<std::uint8_t>(grid.data.size())};
  for (std::size_t i = 0; i < grid.data.size(); ++i) {
    const std::int8_t occupancy = grid.data[i];
    if (occupancy < -1 || occupancy > 100) {
      const Cell cell = map.CellAt(i);
      return MakeError(Fault::kMap,
                       fmt::format("occupancy grid: cell ({}, {}) is {}, expected -1 to 100",
                                   cell.x, cell.y, static_cast<int>(occupancy)));
    }
    map.blocked[i] = occupancy < 0 ? !rules.unknown_is_free : occupancy >= rules.blocked_from;
  }
  return map;
}

Result<CellMap> FromPointCloud(const std::vector<Point>& points, const CloudRules& rules) {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), 0};
  Point high{-low.x_m, -low.y_m, 0};
  for (const Point& point : points) {
    if (!Counts(point, rules)) continue;
    low = {std::min(low.x_m, point.x_m), std::min(low.y_m, point.y_m), 0};
    high = {std::max(high.x_m, point.x_m), std::max(high.y_m, point.y_m), 0};
  }
  if (!(low.x_m <= high.x_m)) {
    return MakeError(Fault::kMap,
                     fmt::format("point cloud: none of its {} points is finite and between {} and "
                                 "{} m high",
                                 points.size(), rules.from_z_m, rules.to_z_m));
  }
  CellMap map;
  map.resolution_m = rules.resolution_m;
  map.origin.at = {low.x_m - rules.margin_m, low.y_m - rules.margin_m, 0};
  const auto cells = [&](double from_m, double to_m) {
    const double count = std::floor((to_m - from_m + 2 * rules.margin_m) / rules.resolution_m) + 1;
    return static_cast<std::int64_t>(std::min(count, 1e15));
  };
  const std::int64_t x = cells(low.x_m, high.x_m), y = cells(low.y_m, high.y_m);
  auto shape = CheckShape(rules.resolution_m, map.origin, x, y, 1);
  if (!shape.ok()) return shape.error();
  map.size_x = static_cast<int>(x);
  map.size_y = static_cast<int>(y);
  std::vector<std::uint8_t> hits(static_cast<std::size_t>(x * y));
  for (const Point& point : points) {
    if (!Counts(point, rules)) continue;
    std::uint8_t& count = hits[map.IndexOf(map.CellOf(point))];
    if (count < 255) ++count;
  }
  const int enough = std::clamp(rules.points_a_cell, 1, 255);
  for (std::uint8_t& cell : hits) cell = cell >= enough;
  map.blocked = std::move(hits);
  return map;
}

void BlockPoints(const std::vector<Point>& points, CellMap& map) {
  for (const Point& point : points) {
    if (!IsFinite(point)) continue;
    const Cell cell = map.CellOf(point);
    if (map.Has(cell)) map.blocked[map.IndexOf(cell)] = 1;
  }
}

CellMap WindowOf(const CellMap& map, const Cell& from, const Cell& to) {
  const Cell least{std::clamp(from.x, 0, map.size_x - 1), std::clamp(from.y, 0, map.size_y - 1), 0};
  const Cell most{std::clamp(to.x, least.x, map.size_x - 1),
                  std::clamp(to.y, least.y, map.size_y - 1), 0};
  CellMap window;
  window.resolution_m = map.resolution_m;
  window.origin = map.origin;
  const double c = std::cos(map.origin.yaw_rad), s = std::sin(map.origin.yaw_rad);
  const double x_m = least.x * map.resolution_m, y_m = least.y * map.resolution_m;
  window.origin.at.x_m += c * x_m - s * y_m;
  window.origin.at.y_m += s * x_m + c * y_m;
  window.size_x = most.x - least.x + 1;
  window.size_y = most.y - least.y + 1;
  window.size_z = map.size_z;
  window.blocked.reserve(static_cast<std::size_t>(window.size_x) * window.size_y * window.size_z);
  for (int z = 0; z < map.size_z; ++z) {
    for (int y = least.y; y <= most.y; ++y) {
      const auto row =
          map.blocked.begin() + static_cast<std::ptrdiff_t>(map.IndexOf({least.x, y, z}));
      window.blocked.insert(window.blocked.end(), row, row + window.size_x);
    }
  }
  return window;
}

}  // namespace musher::navigation
