#pragma once
// Which cells of space a body must not touch: one layer for a body on the ground, several for one
// that flies. It is made of an occupancy grid, a point cloud or an octree. Plain value; any thread.
//
// Cell (0, 0, 0) lies at `origin`, which is its corner with the least coordinates; rows run along
// x, columns along y, both turned by the origin's yaw. With one layer heights are ignored. What is
// outside the map is not known: a body's centre may not be there, its edge may.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

// 32 million cells, some 300 MB in a planner.
inline constexpr std::int64_t kMostCells = std::int64_t{1} << 25;

// The index of a cell along each axis; it may be outside.
struct Cell {
  int x = 0;
  int y = 0;
  int z = 0;

  friend bool operator==(const Cell&, const Cell&) = default;
};

struct CellMap {
  double resolution_m = 0;
  Pose origin;
  int size_x = 0;
  int size_y = 0;
  int size_z = 1;
  std::vector<std::uint8_t> blocked;  // x fastest, then y, then z; 0 is free

  bool flat() const { return size_z == 1; }
  std::size_t count() const { return blocked.size(); }
  bool Has(const Cell& cell) const {
    return cell.x >= 0 && cell.y >= 0 && cell.z >= 0 && cell.x < size_x && cell.y < size_y &&
           cell.z < size_z;
  }
  std::size_t IndexOf(const Cell& cell) const {
    return (static_cast<std::size_t>(cell.z) * size_y + cell.y) * size_x + cell.x;
  }
  Cell CellAt(std::size_t index) const;

  // In units of cells from the origin: the centre of cell (0, 0, 0) is (0.5, 0.5, 0.5).
  Point InCells(const Point& point) const;
  Cell CellOf(const Point& point) const;
  Point CentreOf(const Cell& cell) const;

  // "x 0.00 to 10.00 m, y -2.50 to 2.50 m", for messages about places outside.
  std::string ExtentText() const;
};

// Fails for an empty map, for more than kMostCells and for numbers that are not finite.
Result<> CheckCellMap(const CellMap& map);

// The occupancy of nav_msgs/OccupancyGrid: -1 is unknown, 0 to 100 per cent.
struct OccupancyGrid {
  double resolution_m = 0;
  Pose origin;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::int8_t> data;
};

struct OccupancyRules {
  int blocked_from = 65;  // per cent; the limit that ROS 2's map server writes by default
  bool unknown_is_free = false;
};

Result<CellMap> FromOccupancyGrid(const OccupancyGrid& grid, const OccupancyRules& rules);

// A point cloud as a map of one layer. Points that are not finite are ignored.
struct CloudRules {
  double resolution_m = 0.05;
  double from_z_m = 0.1;  // of the points that count as obstacles: above the floor
  double to_z_m = 2.0;    // and below the ceiling
  double margin_m = 1.0;  // of free space around the points
  int points_a_cell = 1;  // fewer are noise
};

Result<CellMap> FromPointCloud(const std::vector<Point>& points, const CloudRules& rules);

// Blocks the cells of points seen now, for example of a scan; those outside are ignored.
void BlockPoints(const std::vector<Point>& points, CellMap& map);

// The part of a map from one cell to another, along x and y; all of its layers. Both are moved onto
// the map.
CellMap WindowOf(const CellMap& map, const Cell& from, const Cell& to);

}  // namespace musher::navigation
