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
  State state;         // empty: `change` is
  CauseChain change;   // to `state`; empty: not wanted, or before the entries
  CauseChain failure;  // the newest failure, if `change` does not contain it; else empty
  CauseChain refused;  // a request after both that was refused; empty: none, or it is `failure`
  std::string damage;  // what is missing among the entries; empty: nothing

  bool complete() const { return change.complete && failure.complete && refused.complete; }
};

// What to explain.
struct WhyWanted {
  State state{};              // why it was last entered; empty: the current one, and the failure
  std::string actuator{};     // the newest failure of this one; empty: of any
  bool failure_only = false;  // without the change of state
};

// The newest failure is a refused request only if nothing else failed in that run of the
// controller. Fails if the entries of `history` contain neither the change nor a failure, or not
// the change to the state that is named.
Result<Why> FindWhy(const msg::GetHistory::Response& history, const WhyWanted& wanted);

// Whether entries before those of `history` are needed for that answer: for the change, for causes,
// and for a failure that is asked for.
bool NeedsOlderEntries(const msg::GetHistory::Response& history, const WhyWanted& wanted);

// Whether the controller that recorded the last entries was neither stopped nor replaced.
bool EndsWithoutRecord(const msg::GetHistory::Response& history);

}  // namespace musher::cli
