#include "musher/behavior/fsm/reach.hpp"

#include <algorithm>
#include <utility>

namespace musher::fsm {

void Spread(const std::vector<ChartTransition>& transitions, Marks& marked, bool back) {
  bool grows = true;
  while (grows) {
    grows = false;
    for (const ChartTransition& transition : transitions) {
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

std::vector<ChartState> FindPath(const Chart& outermost, std::string_view path) {
  const std::size_t slash = path.find('/');
  const auto found = std::ranges::find(outermost.states, path.substr(0, slash), &Chart::Node::name);
  if (found == outermost.states.end()) return {};
  const ChartState here{&outermost, static_cast<StateId>(found - outermost.states.begin())};
  if (slash == std::string_view::npos) return {here};
  for (const Chart& inside : found->inside) {
    std::vector<ChartState> below = FindPath(inside, path.substr(slash + 1));
    if (below.empty()) continue;
    below.insert(below.begin(), here);
    return below;
  }
  return {};
}

}  // namespace musher::fsm
