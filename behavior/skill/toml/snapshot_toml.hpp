#pragma once
// A snapshot of skills as a TOML text, which a person can read and edit.
//
//   [[run]]
//   skill = "walk"
//   state = "EXECUTING"
//   time_ns = 60000000
//   ...
//   [run.parameters]
//   speed = 0.5

#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/behavior/skill/manager.hpp"
#include "musher/behavior/skill/snapshot.hpp"

namespace musher::skill {

// Fails where one of its texts is not UTF-8 or has a NUL, which TOML cannot represent.
Result<std::string> WriteSnapshot(const ManagerSnapshot& snapshot);

// Reads the text of WriteSnapshot() and restores it like Manager::Restore(). All errors of the
// text, or of the snapshot for this manager, are reported at once, as "file:line:column: error:
// …"; then nothing has changed.
Result<> RestoreSnapshot(Manager& manager, std::string_view text, const std::string& file);

}  // namespace musher::skill
