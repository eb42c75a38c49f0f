#pragma once
// Plans and the field as text for a person. Pure functions.

#include <string>

#include "musher/modules/meilin/plan/route_search.hpp"

namespace musher::meilin {

// A row a step: "  2  fetch (1, 1)  forward  +200 mm    0 deg   1 1 1 200 0 0 0 0".
std::string StepTable(const std::vector<PlanStep>& steps, const Grid& grid);

// The field seen from above, row 5 at the top and column 0 at the right, as the robot sees it that
// enters from below. Each cell has its height, its box and the steps that go there.
std::string FieldDrawing(const BoxMap& map, const std::vector<PlanStep>& steps);

// "2 KFS2, 17.5 s, 1 KFS1 on the way, 9 steps".
std::string RouteSummary(const Route& route);

}  // namespace musher::meilin
