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

// A place where a body of this radius fits.
Point FreePlace(const Clearance& clearance, double radius_m, std::mt19937_64& random);

}  // namespace musher::navigation::testing
