#include "musher/cli/machine/why.hpp"

#include <algorithm>
#include <iterator>

#include "musher/base/code.hpp"

namespace musher::cli {
namespace {

using NewestFirst = std::vector<msg::HistoryEntry>::const_reverse_iterator;

std::string EventOf(const msg::GetHistory::Response& history, NewestFirst entry) {
  const auto i = static_cast<std::size_t>(history.entries.rend() - entry) - 1;
  return i < history.events.size() ? history.events[i] : "";
}

// A cause precedes its effect in the run of one controller: going back, ids only fall.
CauseChain ChainFrom(const msg::GetHistory::Response& history, NewestFirst last) {
  CauseChain chain{{*last}, {EventOf(history, last)}};
  std::uint64_t before = last->id;
  for (auto entry = std::next(last); entry != history.entries.rend(); ++entry) {
    if (entry->id == 0) continue;
    if (entry->id >= before) break;
    before = entry->id;
    if (entry->id != chain.entries.back().cause) continue;
    chain.entries.push_back(*entry);
    chain.events.push_back(EventOf(history, entry));
  }
  chain.complete = chain.entries.back().cause == 0;
  return chain;
}

bool Contains(const CauseChain& chain, const msg::HistoryEntry& entry) {
  return std::find(chain.entries.begin(), chain.entries.end(), entry) != chain.entries.end();
}

}  // namespace

Result<Why> FindWhy(const msg::GetHistory::Response& history, const State& state) {
  const std::vector<msg::HistoryEntry>& entries = history.entries;
  const auto newest = std::find_if(entries.rbegin(), entries.rend(), [&](const auto& entry) {
    return state.empty() ? !entry.state.empty() : entry.state == state;
  });
  const auto failed = std::find_if(entries.rbegin(), entries.rend(),
                                   [](const auto& entry) { return entry.code != kCodeOk; });
  if (newest == entries.rend()) {
    return Error{kCodeFailed, state.empty() ? "these entries contain no state change of the machine"
                                            : "these entries contain no change to " + state};
  }
  Why why{State(newest->state), ChainFrom(history, newest), {}, history.error};
  if (state.empty() && failed != entries.rend() && !Contains(why.change, *failed)) {
    why.failure = ChainFrom(history, failed);
  }
  return why;
}

}  // namespace musher::cli
