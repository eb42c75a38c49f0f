#pragma once
// What commands took, from the journal of a machine.
//
// Waits for the disk. Threads: any.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/cli/config/learned_times.hpp"

namespace musher::cli {

struct CommandTimes {
  std::vector<CommandTime> commands;  // that were done, or overdue; oldest first
  std::string damage;                 // of the journal; empty: all was read
};

// Of entries since then. Errors: the file is not a journal, or not readable at all.
Result<CommandTimes> ReadCommandTimes(const std::string& journal, std::int64_t since_wall_ns);

}  // namespace musher::cli
