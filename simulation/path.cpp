#include "musher/simulation/path.hpp"

#include <algorithm>
#include <deque>
#include <map>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {

std::optional<std::vector<State>> FindPath(const MachineConfig& config, const State& from,
                                           const State& to) {
  std::map<State, State> before = {{from, from}};
  std::deque<State> open = {from};
  while (!open.empty() && !before.contains(to)) {
    const State at = open.front();
    open.pop_front();
    for (const State& next : Reachable(config, at)) {
      // A self-check changes the state only during the start and in Error.
      const bool stays = next == kSelfCheck && config.RankOf(at) && at != kError;
      if (stays || next == kTearDown || before.contains(next)) continue;
      before[next] = at;
      open.push_back(next);
    }
  }
  if (!before.contains(to)) return std::nullopt;
  std::vector<State> path;
  for (State at = to; at != from; at = before.at(at)) path.push_back(at);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace musher::simulation
