#include "musher/behavior/fsm/reach.hpp"

#include <algorithm>
#include <utility>

namespace musher::fsm {

void Spread(const Chart& chart, Marks& marked, bool back) {
  bool grows = true;
  while (grows) {
    grows = false;
    for (const ChartTransition& transition : chart.transitions) {
      const auto [from, to] = back ? std::pair(transition.to, transition.from)
                                   : std::pair(transition.from, transition.to);
      if (!marked[Index(from)] || marked[Index(to)]) continue;
      marked[Index(to)] = grows = true;
    }
  }
}

bool IsRepeated(const Chart& chart, std::size_t transition) {
  const auto before = chart.transitions.begin() + static_cast<std::ptrdiff_t>(transition);
  return std::find(chart.transitions.begin(), before, chart.transitions[transition]) != before;
}

}  // namespace musher::fsm
