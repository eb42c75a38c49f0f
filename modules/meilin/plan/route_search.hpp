#pragma once
// Finds the plans of a field whose boxes (KFS) are known. A plan begins with the straight way from
// the entrance to a cell of row 0, which drives over no box, moves forward, left or right, visits
// no cell twice, and ends in row 5. It takes up to four boxes of kind KFS2
// from the cells beside its path; it drives over no cell with a fake box, or with a KFS2 that it
// has not taken. Boxes of kind KFS1 are the partner's: they are in the way, unless
// PlanRules::kfs1_blocks is false; those on its way are counted then.
//
// The search is exact: it visits every plan, always in the same order. Each plan passes
// ReadActionSequence(). Pure: no clock, no thread. Costs are seconds.

#include <array>
#include <cstdint>
#include <vector>

#include "musher/modules/meilin/field/box_map.hpp"
#include "musher/modules/meilin/field/costs.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"

namespace musher::meilin {

struct Route {
  std::vector<PlanStep> steps;
  double cost_s = 0;
  int kfs2_count = 0;     // fetched
  int kfs1_affected = 0;  // on the way
};

inline constexpr int kMostFetched = 4;

struct RouteBucket {
  std::uint64_t total = 0;    // plans with so many KFS2
  std::vector<Route> routes;  // the best of them, by cost, then by KFS1, then by steps
};
// The index is the number of KFS2.
using Routes = std::array<RouteBucket, kMostFetched + 1>;

struct RouteRules {
  PlanRules plan;  // but for the side, which the map has
  Cell entrance;   // where the robot is before the first step; in row 0
  StepCosts costs;
  std::size_t most_routes = 10;  // of each bucket
  // Cells and fetches that the search visits; only maps full of KFS2 have more.
  std::uint64_t most_visits = 2'000'000;
};

struct RouteReport {
  Routes routes;
  bool complete = true;  // false: the search ended at most_visits
};

RouteReport FindRoutes(const BoxMap& map, const RouteRules& rules = {});

// Why a map has no plan.
inline constexpr const char* kNoPath =
    "no path leads to row 5: fake boxes, and boxes that the robot cannot fetch, are in the way (a "
    "box on a "
    "lower platform is out of reach)";

// The plan that a team sends: the best with 2 KFS2, or 3, or 4, 1 and 0. Null: there is none.
const Route* BestRoute(const Routes& routes);

}  // namespace musher::meilin
