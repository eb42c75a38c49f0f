#include "musher/controller/journal_reader.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <utility>

#include "musher/controller/journal_schema.hpp"
#include "musher/lifecycle/checksum.hpp"

namespace musher {
namespace {

constexpr int kBusyTimeoutMs = 1000;

// What was said about damage, the first time.
using Damage = std::string;

struct Open {
  SQLite::Database database;
  int version = 0;

  // Throws; the message says what is wrong.
  explicit Open(const std::string& path) : database(path, SQLite::OPEN_READONLY, kBusyTimeoutMs) {
    database.exec("PRAGMA cell_size_check = ON");
    // Without it a file that was cut short is not read at all. Nothing is written here.
    database.exec("PRAGMA writable_schema = ON");
    if (database.execAndGet("PRAGMA application_id").getInt() != journal_schema::kApplicationId) {
      throw SQLite::Exception("it is not a journal");
    }
    version = database.execAndGet("PRAGMA user_version").getInt();
    if (version < 1 || version > journal_schema::kVersion) {
      throw SQLite::Exception("its version is " + std::to_string(version) + ", not " +
                              std::to_string(journal_schema::kVersion));
    }
  }
};

std::uint64_t Unsigned(SQLite::Statement& row, int column) {
  return static_cast<std::uint64_t>(row.getColumn(column).getInt64());
}

JournalEntry EntryOf(SQLite::Statement& row) {
  JournalEntry entry;
  entry.wall_ns = row.getColumn(1).getInt64();
  entry.steady_ns = row.getColumn(2).getInt64();
  entry.epoch = Unsigned(row, 3);
  entry.switch_number = Unsigned(row, 4);
  entry.kind = row.getColumn(5).getString();
  entry.actuator = row.getColumn(6).getString();
  entry.code = row.getColumn(7).getInt();
  entry.message = row.getColumn(8).getString();
  entry.data = row.getColumn(9).getString();
  if (row.getColumnCount() == 10) return entry;  // of version 1
  entry.id = Unsigned(row, 10);
  entry.cause = Unsigned(row, 11);
  entry.state = row.getColumn(12).getString();
  return entry;
}

// What a row of inputs holds, or why not.
Result<JournalInput> InputOf(SQLite::Statement& row) {
  JournalInput input;
  input.wall_ns = row.getColumn(1).getInt64();
  const std::string kind = row.getColumn(2).getString();
  const std::string data = row.getColumn(3).getString();
  const std::string where = "input " + std::to_string(row.getColumn(0).getInt64()) + ": ";
  const auto take = [&](auto decoded, auto make) -> Result<JournalInput> {
    if (!decoded) return Error{decoded.error().code, where + decoded.error().message};
    input.what = make(std::move(decoded).value());
    return input;
  };
  const auto as_it_is = [](auto value) { return value; };
  if (Fnv1a(data) != Unsigned(row, 4)) return Error{kCodeFailed, where + "its checksum is wrong"};
  if (kind == "config") return take(recording::DecodeConfig(data), as_it_is);
  if (kind == "event") return take(recording::DecodeEvent(data), as_it_is);
  if (kind == "machine") {
    return take(recording::DecodeSnapshot(data), [](recording::Snapshot snapshot) {
      return std::make_shared<const recording::Snapshot>(std::move(snapshot));
    });
  }
  return Error{kCodeFailed, where + "its kind '" + kind + "' is not known"};
}

// A table, read by id from its end or from its beginning until there is damage.
class TableReader {
 public:
  // `take` is told of each row; it may throw SQLite::Exception.
  TableReader(const SQLite::Database& database, std::string columns, std::string table)
      : database_(database), columns_(std::move(columns)), table_(std::move(table)) {}

  // Of rows with wall_ns >= since the newest `limit`, more or less where there is damage.
  template <class Take>
  Damage Read(std::int64_t since, std::int64_t limit, const Take& take) {
    const Damage damage = ReadFrom("DESC", since, limit, take);
    if (!damage.empty()) static_cast<void>(ReadFrom("ASC", since, limit, take));
    return damage;
  }

 private:
  template <class Take>
  Damage ReadFrom(const std::string& direction, std::int64_t since, std::int64_t limit,
                  const Take& take) {
    SQLite::Statement select(database_, "SELECT " + columns_ + " FROM " + table_ +
                                            " WHERE wall_ns >= ? ORDER BY id " + direction +
                                            " LIMIT ?");
    select.bind(1, since);
    select.bind(2, limit);
    const bool upwards = direction == "ASC";
    try {
      for (bool first = true; select.executeStep(); first = false) {
        const auto id = select.getColumn(0).getInt64();
        if (!first && (upwards ? id <= last_ : id >= last_)) return "its rows are out of order";
        if (upwards && id >= lowest_) break;  // those have been read from the end
        last_ = id;
        take(id, select);
        if (!upwards) lowest_ = id;
      }
      return {};
    } catch (const SQLite::Exception& e) {
      return e.what();
    }
  }

  const SQLite::Database& database_;
  const std::string columns_;
  const std::string table_;
  std::int64_t last_ = 0;
  std::int64_t lowest_ = INT64_MAX;  // that was read from the end
};

const char* EntryColumns(int version) {
  return version == 1 ? journal_schema::kEntryColumnsVersion1 : journal_schema::kEntryColumns;
}

std::string Tell(std::size_t count, const char* what, const Damage& damage) {
  if (damage.empty()) return {};
  return "read " + std::to_string(count) + " " + what + "; the rest is damaged: " + damage;
}

Error Unreadable(const std::string& path, const std::string& why) {
  return {kCodeFailed, "can't read the journal " + path + ": " + why};
}

}  // namespace

Result<JournalReading> ReadJournal(const std::string& path, std::int64_t since_wall_ns,
                                   std::size_t limit) try {
  const Open journal(path);
  std::map<std::int64_t, JournalEntry> entries;
  TableReader reader(journal.database, EntryColumns(journal.version), "entry");
  const Damage damage =
      reader.Read(since_wall_ns, static_cast<std::int64_t>(limit),
                  [&](std::int64_t id, SQLite::Statement& row) { entries[id] = EntryOf(row); });
  JournalReading reading;
  reading.damage = Tell(entries.size(), "entries", damage);
  while (entries.size() > limit) entries.erase(entries.begin());
  for (auto& [id, entry] : entries) reading.entries.push_back(std::move(entry));
  return reading;
} catch (const SQLite::Exception& e) {
  return Unreadable(path, e.what());
}

Result<Recording> ReadRecording(const std::string& path) try {
  const Open journal(path);
  if (journal.version == 1) {
    return Unreadable(path, "its version is 1, which did not record what went into the decisions");
  }
  std::map<std::int64_t, JournalItem> items;
  Damage damage;
  const auto note = [&damage](const Damage& more) {
    if (damage.empty()) damage = more;
  };
  TableReader inputs(journal.database, journal_schema::kInputColumns, "input");
  note(inputs.Read(INT64_MIN, -1, [&](std::int64_t id, SQLite::Statement& row) {
    auto input = InputOf(row);
    if (input) {
      items[id] = std::move(input).value();
    } else {
      note(input.error().message);
    }
  }));
  TableReader entries(journal.database, EntryColumns(journal.version), "entry");
  note(entries.Read(INT64_MIN, -1,
                    [&](std::int64_t id, SQLite::Statement& row) { items[id] = EntryOf(row); }));
  Recording recording;
  recording.damage = Tell(items.size(), "entries and inputs", damage);
  for (auto& [id, item] : items) recording.rows.push_back({id, std::move(item)});
  return recording;
} catch (const SQLite::Exception& e) {
  return Unreadable(path, e.what());
}

}  // namespace musher
