#pragma once
// Shortens a path and rounds its corners, as far as a body of a radius fits everywhere: OMPL's
// shortcuts and its smoothing by B-splines. Deterministic by the seed. Any thread.

#include <cstdint>
#include <vector>

#include "musher/navigation/planner/clearance.hpp"

namespace musher::navigation {

struct SmoothingRules {
  int shortcuts = 400;     // attempts at most; 0: none
  int spline_steps = 5;    // each halves the distance between points; 0: none
  double spacing_m = 1.0;  // of the points with which the splines begin: how round corners become
  std::uint32_t seed = 1;
};

// `points` has at least one point, and the body fits along it. The first and the last point stay.
std::vector<Point> Smoothed(const std::vector<Point>& points, const Clearance& clearance,
                            double radius_m, const SmoothingRules& rules);

}  // namespace musher::navigation
