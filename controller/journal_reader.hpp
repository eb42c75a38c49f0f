#pragma once
// Reads a journal: while a controller writes it, after one crashed, or what is left of a damaged
// one. Changes nothing in the file.
//
// Of a damaged file all is read that can be reached from either end, and `damage` says what is
// missing. Errors: what is no journal, or not readable at all.
//
// Threads: any.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "musher/controller/journal.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher {

struct JournalReading {
  std::vector<JournalEntry> entries;  // oldest first
  std::string damage;  // "read 812 entries; the rest is damaged: ..."; empty: all was read
};

// The newest `limit` entries with wall_ns >= since_wall_ns.
Result<JournalReading> ReadJournal(const std::string& path, std::int64_t since_wall_ns,
                                   std::size_t limit);

struct JournalRow {
  std::int64_t id = 0;  // one more than that of the row before, unless something is missing
  JournalItem item;
};

struct Recording {
  std::vector<JournalRow> rows;  // by id
  std::string damage;
};

// All that a replay needs. A journal of version 1 has none of it, which is an error.
Result<Recording> ReadRecording(const std::string& path);

}  // namespace musher
