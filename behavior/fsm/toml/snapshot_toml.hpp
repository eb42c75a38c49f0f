#pragma once
// A snapshot as a TOML text, which a person can read and edit.
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

#include "musher/base/result.hpp"
#include "musher/behavior/fsm/snapshot.hpp"

namespace musher::fsm {

// Fails where one of its texts is not UTF-8 or has a NUL, which TOML cannot represent.
Result<std::string> WriteSnapshot(const Snapshot& snapshot);

// Reads the text of WriteSnapshot() and restores it like Machine::Restore(). All errors of the
// text, or of the snapshot for this machine, are reported at once, as "file:line:column: error:
// ..."; then nothing has changed.
Result<> RestoreSnapshot(Machine& machine, std::string_view text, const std::string& file,
                         Time now);

}  // namespace musher::fsm
