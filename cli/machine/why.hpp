#pragma once
// Why the machine is in its state, and what went wrong last: chains of causes among the journal's
// entries.

#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher::cli {

// An entry, then its cause, then the cause of that, ...
struct CauseChain {
  std::vector<msg::HistoryEntry> entries;
  std::vector<std::string> events{};  // of the entries
  bool complete = true;               // false: the cause of the last one was not read
};

struct Why {
  State state;
  CauseChain change;   // to `state`
  CauseChain failure;  // the newest failure, if `change` does not contain it; else empty
  std::string damage;  // what is missing among the entries; empty: nothing
};

// Why `state` was last entered; empty: why the machine is in its current state, and the newest
// failure. Fails if the entries of `history` do not contain the change.
Result<Why> FindWhy(const msg::GetHistory::Response& history, const State& state);

// Whether the controller that recorded the last entries was neither stopped nor replaced.
bool EndsWithoutRecord(const msg::GetHistory::Response& history);

}  // namespace musher::cli
