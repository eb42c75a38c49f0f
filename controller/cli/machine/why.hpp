#pragma once
// Why the machine is in its state: the chain of causes among the journal's entries.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher::cli {

struct Why {
  State state;
  // The entry of the change to `state`, then its cause, then the cause of that, ...
  std::vector<msg::HistoryEntry> chain;
  std::vector<std::string> events;  // of the chain
  bool complete = true;             // false: the cause of the last one is not among the entries
  std::string damage{};             // what is missing among the entries; empty: nothing
};

// Why `state` was last entered; empty: why the machine is in its current state. Fails if the
// entries of `history` do not contain the change.
Result<Why> FindWhy(const msg::GetHistory::Response& history, const State& state);

}  // namespace musher::cli
