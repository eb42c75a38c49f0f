#include "musher/controller/cli/machine/why.hpp"

#include <algorithm>
#include <iterator>

namespace musher::cli {

Result<Why> FindWhy(const msg::GetHistory::Response& history, const State& state) {
  const std::vector<msg::HistoryEntry>& entries = history.entries;
  const auto event_of = [&](const auto& entry) {
    const auto i = static_cast<std::size_t>(entries.rend() - entry) - 1;
    return i < history.events.size() ? history.events[i] : "";
  };
  const auto newest = std::find_if(entries.rbegin(), entries.rend(), [&](const auto& entry) {
    return state.empty() ? !entry.state.empty() : entry.state == state;
  });
  if (newest == entries.rend()) {
    return Error{kCodeFailed, state.empty() ? "these entries contain no state change of the machine"
                                            : "these entries contain no change to " + state};
  }
  Why why{State(newest->state), {*newest}, {event_of(newest)}, true};
  // A cause precedes its effect in the run of one controller: going back, ids only fall.
  std::uint64_t before = newest->id;
  for (auto entry = std::next(newest); entry != entries.rend(); ++entry) {
    if (entry->id == 0) continue;
    if (entry->id >= before) break;
    before = entry->id;
    if (entry->id != why.chain.back().cause) continue;
    why.chain.push_back(*entry);
    why.events.push_back(event_of(entry));
  }
  why.complete = why.chain.back().cause == 0;
  why.damage = history.error;
  return why;
}

}  // namespace musher::cli
