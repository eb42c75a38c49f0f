#include "musher/cli/machine/why.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "musher/base/code.hpp"

namespace musher::cli {
namespace {

using NewestFirst = std::vector<msg::HistoryEntry>::const_reverse_iterator;

std::string EventOf(const msg::GetHistory::Response& history, const NewestFirst& entry) {
  const auto i = static_cast<std::size_t>(history.entries.rend() - entry) - 1;
  return i < history.events.size() ? history.events[i] : "";
}

// A cause precedes its effect in the run of one controller: going back, ids only fall.
CauseChain ChainFrom(const msg::GetHistory::Response& history, const NewestFirst& last) {
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

// A hung process is killed after its backtrace: the hang is the failure, and it has the backtrace.
void BeginAtHang(CauseChain& chain, const msg::GetHistory::Response& history) {
  const auto hang = std::ranges::find(chain.events, "actuator_hung");
  if (hang == chain.events.end() || chain.events.front() != "process_exited") return;
  const auto before = hang - chain.events.begin();
  chain.entries.erase(chain.entries.begin(), chain.entries.begin() + before);
  chain.events.erase(chain.events.begin(), hang);
  msg::HistoryEntry& hung = chain.entries.front();
  for (std::size_t i = 0; i < history.entries.size() && i < history.events.size(); ++i) {
    const msg::HistoryEntry& entry = history.entries[i];
    const bool of_it = entry.id > hung.id && entry.actuator == hung.actuator;
    if (!of_it || history.events[i] != "backtrace_taken") continue;
    hung.data = entry.data;
    return;
  }
}

// A request that was refused has a code, but it changes nothing: what failed in this run of the
// controller is why it was refused.
bool IsRefusedRequest(const std::string& event) {
  return event == "switch_refused" || event == "switch_superseded" || event == "policy_refused" ||
         event == "policy_switch_refused" || event == "request_refused";
}

NewestFirst NewestFailure(const msg::GetHistory::Response& history, const std::string& actuator) {
  const NewestFirst end = history.entries.rend();
  NewestFirst refused = end;
  std::uint64_t before = UINT64_MAX;  // ids only fall on the way back through one run
  for (NewestFirst entry = history.entries.rbegin(); entry != end; ++entry) {
    if (refused != end && entry->id != 0 && entry->id >= before) break;
    if (entry->id != 0) before = entry->id;
    if (entry->code == kCodeOk || (!actuator.empty() && entry->actuator != actuator)) continue;
    if (!IsRefusedRequest(EventOf(history, entry))) return entry;
    if (refused == end) refused = entry;
  }
  return refused;
}

// The newest refused request, unless something has failed or changed since.
NewestFirst LastRefusal(const msg::GetHistory::Response& history) {
  const NewestFirst end = history.entries.rend();
  for (NewestFirst entry = history.entries.rbegin(); entry != end; ++entry) {
    const std::string event = EventOf(history, entry);
    const bool refused = event == "switch_refused" || event == "policy_refused";
    if (refused || event == "request_refused") return entry;
    if (!entry->state.empty()) break;
    if (entry->code != kCodeOk && !IsRefusedRequest(event)) break;
  }
  return end;
}

bool Contains(const CauseChain& chain, const msg::HistoryEntry& entry) {
  return std::find(chain.entries.begin(), chain.entries.end(), entry) != chain.entries.end();
}

}  // namespace

bool EndsWithoutRecord(const msg::GetHistory::Response& history) {
  const auto last =
      std::find_if(history.events.rbegin(), history.events.rend(), [](const std::string& event) {
        return event == "controller_started" || event == "machine_stopped" ||
               event == "controller_fenced";
      });
  return last != history.events.rend() && *last == "controller_started";
}

Result<Why> FindWhy(const msg::GetHistory::Response& history, const WhyWanted& wanted) {
  const NewestFirst end = history.entries.rend();
  const State& state = wanted.state;
  const NewestFirst newest =
      std::find_if(history.entries.rbegin(), end, [&](const msg::HistoryEntry& entry) {
        return state.empty() ? !entry.state.empty() : entry.state == state;
      });
  if (newest == end && !state.empty()) {
    return Error{kCodeFailed, "these entries contain no change to " + state};
  }
  Why why{{}, {}, {}, {}, history.error};
  if (newest != end && !wanted.failure_only) {
    why.state = State(newest->state);
    why.change = ChainFrom(history, newest);
  }
  why.change.complete = wanted.failure_only || (why.change.complete && newest != end);
  const NewestFirst failed = state.empty() ? NewestFailure(history, wanted.actuator) : end;
  if (failed != end && !Contains(why.change, *failed)) {
    why.failure = ChainFrom(history, failed);
    BeginAtHang(why.failure, history);
  }
  const NewestFirst refused = state.empty() ? LastRefusal(history) : end;
  if (refused != end && refused != failed) why.refused = ChainFrom(history, refused);
  if (newest == end && failed == end) {
    return Error{kCodeFailed, "these entries contain no state change of the machine"};
  }
  return why;
}

bool NeedsOlderEntries(const msg::GetHistory::Response& history, const WhyWanted& wanted) {
  const auto why = FindWhy(history, wanted);
  if (!why || !why.value().complete()) return true;
  if (!wanted.failure_only && wanted.actuator.empty()) return false;
  const NewestFirst failed = NewestFailure(history, wanted.actuator);
  if (failed == history.entries.rend()) return true;
  return IsRefusedRequest(EventOf(history, failed));
}

}  // namespace musher::cli
