#pragma once
// An area on the ground: a polygon with holes. Metres in the frame of the map. Plain values and
// pure functions; any thread.

#include <cmath>
#include <cstddef>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::coverage {

struct GroundPoint {
  double x_m = 0;
  double y_m = 0;

  friend bool operator==(const GroundPoint&, const GroundPoint&) = default;
};

// Its corners in either direction; the last one is joined to the first one.
using Ring = std::vector<GroundPoint>;

struct Region {
  Ring boundary;
  std::vector<Ring> holes;
};

struct Edge {
  GroundPoint from;
  GroundPoint to;
};

inline constexpr std::size_t kMostCorners = 400;  // of a region

// The region without corners that are repeated, or why it is none: fewer than three corners, a
// coordinate that is not finite or above 100 km, more than kMostCorners, no area, rings that touch
// or cross themselves or each other, a hole outside of the boundary or in another hole.
Result<Region> Checked(const Region& region);

double Distance(const GroundPoint& a, const GroundPoint& b);
double Distance(const GroundPoint& point, const Edge& edge);
// 0: they cross.
double Distance(const Edge& a, const Edge& b);
// Positive when the corners go to the left.
double SignedArea(const Ring& ring);
std::vector<Edge> EdgesOf(const Ring& ring);
// Of the boundary and of all holes.
std::vector<Edge> EdgesOf(const Region& region);
// Whether the point is in the boundary and in no hole.
bool Contains(const std::vector<Edge>& edges, const GroundPoint& point);
// Turned to the left around the origin.
GroundPoint Turned(const GroundPoint& point, double angle_rad);
Region Turned(const Region& region, double angle_rad);

}  // namespace musher::coverage
