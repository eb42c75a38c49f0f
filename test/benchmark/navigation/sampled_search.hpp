#pragma once
// A search by samples, as a comparison for the planner's search from cell to cell.

#include <optional>
#include <string>

#include "musher/navigation/planner/clearance.hpp"

namespace musher::benchmark {

// The length of the path that OMPL's "RRTConnect", "RRT*" or "BIT*" finds within this CPU time;
// none if it finds none. The last two use all of it.
std::optional<double> SampledLength(const std::string& planner,
                                    const navigation::Clearance& clearance, double radius_m,
                                    const navigation::Point& start, const navigation::Point& goal,
                                    double seconds);

}  // namespace musher::benchmark
