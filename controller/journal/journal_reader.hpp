#pragma once
// Reads a journal: while a controller writes it, after a crash, or the rest of a damaged one. Never
// changes the file.
//
// A damaged file is read as far as possible from both ends, and `damage` says what is missing.
// Errors: the file is not a journal, or not readable at all.
//
// Threads: any.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/controller/journal/journal.hpp"

namespace musher {

struct JournalReading {
  std::vector<JournalEntry> entries;  // oldest first
  std::string damage;  // "read 812 entries; the rest is damaged: ..."; empty: all was read
};

// The newest `limit` entries with wall_ns >= since_wall_ns.
Result<JournalReading> ReadJournal(const std::string& path, std::int64_t since_wall_ns,
                                   std::size_t limit);

struct JournalRow {
  std::int64_t id = 0;  // the previous row has the number before, unless rows are missing
  JournalItem item;
};

struct JournalRows {
  std::vector<JournalRow> rows;  // by id
  std::string damage;
};

// Everything that a replay needs.
Result<JournalRows> ReadRecording(const std::string& path);

}  // namespace musher
