#pragma once
// Why the machine is in its state: the chain of causes in what the journal tells.

#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"

namespace musher::cli {

struct Why {
  State state;
  // That which tells that the machine went there, then its cause, then the cause of that, ...
  std::vector<msg::HistoryEntry> chain;
  bool complete = true;  // false: the last one has a cause that is not among the entries
};

// Why `state` was entered last; empty: why the machine is where it is. `entries` oldest first.
// Fails when they do not tell of it.
Result<Why> FindWhy(const std::vector<msg::HistoryEntry>& entries, const State& state);

}  // namespace musher::cli
