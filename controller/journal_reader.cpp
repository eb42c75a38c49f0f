#include <SQLiteCpp/SQLiteCpp.h>

#include <algorithm>

#include "musher/controller/journal.hpp"
#include "musher/controller/journal_schema.hpp"

namespace musher {
namespace {

constexpr int kBusyTimeoutMs = 1000;

JournalEntry EntryOf(SQLite::Statement& row) {
  JournalEntry entry;
  entry.wall_ns = row.getColumn(0).getInt64();
  entry.steady_ns = row.getColumn(1).getInt64();
  entry.epoch = static_cast<std::uint64_t>(row.getColumn(2).getInt64());
  entry.switch_number = static_cast<std::uint64_t>(row.getColumn(3).getInt64());
  entry.kind = row.getColumn(4).getString();
  entry.actuator = row.getColumn(5).getString();
  entry.code = row.getColumn(6).getInt();
  entry.message = row.getColumn(7).getString();
  entry.data = row.getColumn(8).getString();
  return entry;
}

}  // namespace

Result<std::vector<JournalEntry>> ReadJournal(const std::string& path, std::int64_t since_wall_ns,
                                              std::size_t limit) try {
  const SQLite::Database database(path, SQLite::OPEN_READONLY, kBusyTimeoutMs);
  SQLite::Statement select(database, journal_schema::kSelect);
  select.bind(1, since_wall_ns);
  select.bind(2, static_cast<std::int64_t>(limit));
  std::vector<JournalEntry> entries;
  while (select.executeStep()) entries.push_back(EntryOf(select));
  std::reverse(entries.begin(), entries.end());
  return entries;
} catch (const SQLite::Exception& e) {
  return Error{kCodeFailed, "can't read the journal " + path + ": " + e.what()};
}

}  // namespace musher
