#pragma once
// Maps for tests and benchmarks, drawn or random.

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "musher/navigation/planner/clearance.hpp"

namespace musher::navigation::testing {

// One character a square of `size_m`, of `cells` times `cells` cells; '#' is blocked. The first
// line is the one with the highest y. The corner with the least coordinates is at (0, 0).
CellMap Drawn(const std::vector<std::string>& lines, double size_m, int cells = 1);

// Free cells of `size_m` squared, with boxes until `share` of the cells is blocked.
CellMap RandomBoxes(std::uint64_t seed, double size_m, double resolution_m, double share);

struct Rectangle {
  double x_m = 0, y_m = 0;
  double to_x_m = 0, to_y_m = 0;
};

// All of it is blocked but these parts; the corner with the least coordinates is at (0, 0).
CellMap Carved(double size_x_m, double size_y_m, double resolution_m,
               const std::vector<Rectangle>& free);

// A corridor of 0.8 m along x, around y = 1.4, from x = 2.7 to 11.3, with a room of 2.5 m at each
// end and a bay of 1 m at `bay_m` to its left.
CellMap CorridorWithABay(double bay_m);

// A place where a body of this radius fits.
Point FreePlace(const Clearance& clearance, double radius_m, std::mt19937_64& random);

}  // namespace musher::navigation::testing
