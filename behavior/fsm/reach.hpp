#pragma once
// What static checks of charts have in common.

#include <cstddef>
#include <vector>

#include "musher/behavior/fsm/chart.hpp"

namespace musher::fsm {

using Marks = std::vector<bool>;  // by state

// Adds to `marked` all states reachable from there; with `back`, all states that lead there.
void Spread(const Chart& chart, Marks& marked, bool back);

// Whether an earlier transition is the same, with the same text.
bool IsRepeated(const Chart& chart, std::size_t transition);

}  // namespace musher::fsm
