#pragma once
// What commands took, from the journal of a machine. SetUp is no command: it takes from the start
// of a process until the actuator has accepted the controller, which is what its limit is about.
//
// Threads: any. ReadCommandTimes() waits for the disk.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/cli/config/learned_times.hpp"
#include "musher/controller/journal/journal.hpp"

namespace musher::cli {

// Of these entries, oldest first, of the file `journal`.
std::vector<CommandTime> CommandTimesOf(const std::vector<JournalEntry>& entries,
                                        const std::string& journal);

struct CommandTimes {
  std::vector<CommandTime> commands;  // that were done, or overdue; oldest first
  std::string damage;                 // of the journal; empty: all was read
};

// Of entries since then. Errors: the file is not a journal, or not readable at all.
Result<CommandTimes> ReadCommandTimes(const std::string& journal, std::int64_t since_wall_ns);

}  // namespace musher::cli
