#pragma once
// A snapshot as a TOML text, which a person can read and mend.
//
//   machine = "show"
//   running = true
//   mode = "NORMAL"
//   state = "TRACKING"
//   time_ns = 60000000
//   ...
//   [states.TRACKING]
//   lost_for = 20000000

#include <string>
#include <string_view>

#include "musher/behavior/fsm/snapshot.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::fsm {

// Fails where a text of it is not UTF-8 without NUL, which TOML cannot hold.
Result<std::string> WriteSnapshot(const Snapshot& snapshot);

// Reads what WriteSnapshot() wrote and restores it, as Machine::Restore() says. All that is wrong
// with the text, or with the snapshot for this machine, is told at once, as "file:line:column:
// error: ..."; then nothing has changed.
Result<> RestoreSnapshot(Machine& machine, std::string_view text, const std::string& file,
                         Time now);

}  // namespace musher::fsm
