#pragma once
// What static checks and drawings of charts have in common.

#include <cstddef>
#include <string_view>
#include <vector>

#include "musher/behavior/fsm/chart.hpp"

namespace musher::fsm {

using Marks = std::vector<bool>;  // by state

// Adds to `marked` all states reachable from there; with `back`, all states that lead there. Each
// transition has its two states in the same chart.
void Spread(const std::vector<ChartTransition>& transitions, Marks& marked, bool back);

// Whether an earlier transition is the same, with the same text.
bool IsRepeated(const Chart& chart, std::size_t transition);

// A state in the chart of its machine.
struct ChartState {
  const Chart* chart = nullptr;
  StateId state = kNoState;
};

// A path as ChartTransition::target has it, from the chart of the outermost machine down. Empty:
// there is no such state.
std::vector<ChartState> FindPath(const Chart& outermost, std::string_view path);

}  // namespace musher::fsm
