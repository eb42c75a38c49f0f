#include "musher/controller/journal/journal_reader.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/journal/journal_checksum.hpp"
#include "musher/controller/journal/journal_schema.hpp"

namespace musher {
namespace {

constexpr int kReaderBusyTimeoutMs = 1000;

// The first error found; empty: none.
using Damage = std::string;

constexpr const char* kNotAsWritten = ": wrong checksum or missing data";

// The name that SQLite opens. Beside a journal that no process writes now, SQLite would make a
// shared memory file. A reader that may not write there reads the file as it is.
std::string NameToOpen(const std::string& path) {
  const std::filesystem::path file(path);
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code error;
  const bool written = std::filesystem::exists(path + "-wal", error);
  if (written || error || access(folder.c_str(), W_OK) == 0) return path;
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%') {
      uri += "%25";
    } else if (c == '?') {
      uri += "%3f";
    } else if (c == '#') {
      uri += "%23";
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

struct Open {
  SQLite::Database database;

  // Throws; the message says what is wrong.
  explicit Open(const std::string& path)
      : database(NameToOpen(path), SQLite::OPEN_READONLY | SQLite::OPEN_URI, kReaderBusyTimeoutMs) {
    database.exec("PRAGMA cell_size_check = ON");
    // Without this SQLite does not read a truncated file at all. This connection never writes.
    database.exec("PRAGMA writable_schema = ON");
    if (database.execAndGet("PRAGMA application_id").getInt() != journal_schema::kApplicationId) {
      throw SQLite::Exception("it is not a journal");
    }
    const auto version = database.execAndGet("PRAGMA user_version").getInt64();
    if (version != journal_schema::kVersion) {
      throw SQLite::Exception(journal_schema::OtherVersion(version));
    }
  }
};

std::uint64_t Unsigned(SQLite::Statement& row, int column) {
  return static_cast<std::uint64_t>(row.getColumn(column).getInt64());
}

// An entry, or why it is damaged.
Result<JournalEntry> EntryOf(SQLite::Statement& row) {
  JournalEntry entry;
  const auto id = row.getColumn(0).getInt64();
  const Error damaged{kCodeFailed, "entry " + std::to_string(id) + kNotAsWritten};
  if (row.getColumn(5).isNull()) return damaged;
  entry.wall_ns = row.getColumn(1).getInt64();
  entry.steady_ns = row.getColumn(2).getInt64();
  entry.epoch = Epoch(Unsigned(row, 3));
  entry.switch_number = CommandNumber(Unsigned(row, 4));
  entry.kind = row.getColumn(5).getString();
  entry.actuator = row.getColumn(6).getString();
  entry.code = row.getColumn(7).getInt();
  entry.message = row.getColumn(8).getString();
  entry.data = row.getColumn(9).getString();
  entry.id = RecordId(Unsigned(row, 10));
  entry.cause = RecordId(Unsigned(row, 11));
  entry.state = State(row.getColumn(12).getString());
  entry.event = row.getColumn(14).getString();
  const auto checksum = row.getColumn(13);
  if (checksum.isNull() || checksum.getInt64() != ChecksumOf(id, entry)) return damaged;
  return entry;
}

// An input, or why it can't be believed.
Result<JournalInput> InputOf(SQLite::Statement& row) {
  JournalInput input;
  const auto id = row.getColumn(0).getInt64();
  input.wall_ns = row.getColumn(1).getInt64();
  const std::string kind = row.getColumn(2).getString();
  const std::string data = row.getColumn(3).getString();
  const std::string where = "input " + std::to_string(id);
  if (ChecksumOf(id, input.wall_ns, kind, data) != row.getColumn(4).getInt64()) {
    return Error{kCodeFailed, where + kNotAsWritten};
  }
  const auto take = [&](auto decoded, auto make) -> Result<JournalInput> {
    if (!decoded) return Error{decoded.error().code, where + ": " + decoded.error().message};
    input.what = make(std::move(decoded).value());
    return input;
  };
  const auto as_it_is = [](auto value) { return value; };
  if (kind == "config") return take(recording::DecodeConfig(data), as_it_is);
  if (kind == "event") return take(recording::DecodeEvent(data), as_it_is);
  if (kind == "machine") {
    return take(recording::DecodeSnapshot(data), [](recording::MachineSnapshot snapshot) {
      return std::make_shared<const recording::MachineSnapshot>(std::move(snapshot));
    });
  }
  return Error{kCodeFailed, where + ": its kind '" + kind + "' is not known"};
}

// A table, read by id from its end, and from its beginning when there is damage.
class JournalTable {
 public:
  JournalTable(const SQLite::Database& database, std::string columns, std::string table)
      : database_(database), columns_(std::move(columns)), table_(std::move(table)) {}

  // Reads the newest `limit` rows with wall_ns >= since; with damage the number may differ. `take`
  // gets each row and returns its damage.
  template <class Take>
  Damage Read(std::int64_t since, std::size_t limit, const Take& take) {
    if (!ReadFrom("DESC", since, limit, take)) ReadFrom("ASC", since, limit, take);
    return damage_;
  }

 private:
  // Returns whether it read all rows.
  template <class Take>
  bool ReadFrom(const std::string& direction, std::int64_t since, std::size_t limit,
                const Take& take) {
    SQLite::Statement select(
        database_, "SELECT " + columns_ + " FROM " + table_ + " ORDER BY id " + direction);
    const bool upwards = direction == "ASC";
    try {
      for (bool first = true; limit > 0 && select.executeStep(); first = false) {
        const auto id = select.getColumn(0).getInt64();
        if (upwards && id >= lowest_) return true;  // the rest was read from the end
        const bool in_order = first || (upwards ? id > last_ : id < last_);
        if (!in_order) throw SQLite::Exception("its rows are out of order");
        last_ = id;
        if (!upwards) lowest_ = id;
        const auto wall_ns = select.getColumn(1);  // never null in an undamaged row
        if (!wall_ns.isNull() && wall_ns.getInt64() < since) continue;
        Note(take(id, select));
        --limit;
      }
      return true;
    } catch (const SQLite::Exception& e) {
      Note(e.what());
      return false;
    }
  }

  void Note(const Damage& damage) {
    if (damage_.empty()) damage_ = damage;
  }

  const SQLite::Database& database_;
  const std::string columns_;
  const std::string table_;
  Damage damage_;
  std::int64_t last_ = 0;
  std::int64_t lowest_ = INT64_MAX;  // lowest id read from the end
};

std::string DamageText(std::size_t count, const char* what, const Damage& damage) {
  if (damage.empty()) return {};
  return "read " + std::to_string(count) + " " + what + "; the rest is damaged: " + damage;
}

// SQLite gives no reason for a file that cannot be opened.
Error Unreadable(const std::string& path, const std::string& why) {
  const UniqueFd file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid()) return SystemError("can't read the journal " + path);
  return {kCodeFailed, "can't read the journal " + path + ": " + why};
}

}  // namespace

Result<JournalReading> ReadJournal(const std::string& path, std::int64_t since_wall_ns,
                                   std::size_t limit) try {
  const Open journal(path);
  std::map<std::int64_t, JournalEntry> entries;
  JournalTable reader(journal.database, journal_schema::kEntryColumns, "entry");
  const auto take = [&](std::int64_t id, SQLite::Statement& row) -> Damage {
    auto entry = EntryOf(row);
    if (!entry) return entry.error().message;
    entries[id] = std::move(entry).value();
    return {};
  };
  const Damage damage = reader.Read(since_wall_ns, limit, take);
  JournalReading reading;
  reading.damage = DamageText(entries.size(), "entries", damage);
  while (entries.size() > limit) entries.erase(entries.begin());
  for (auto& [id, entry] : entries) reading.entries.push_back(std::move(entry));
  return reading;
} catch (const SQLite::Exception& e) {
  return Unreadable(path, e.what());
}

Result<JournalRows> ReadRecording(const std::string& path) try {
  const Open journal(path);
  std::map<std::int64_t, JournalItem> items;
  const auto read = [&](const char* columns, const char* table, const auto& make) {
    JournalTable reader(journal.database, columns, table);
    return reader.Read(INT64_MIN, SIZE_MAX, [&](std::int64_t id, SQLite::Statement& row) -> Damage {
      auto item = make(row);
      if (!item) return item.error().message;
      items[id] = std::move(item).value();
      return {};
    });
  };
  const Damage of_inputs = read(journal_schema::kInputColumns, "input", InputOf);
  const Damage of_entries = read(journal_schema::kEntryColumns, "entry", EntryOf);
  const Damage damage = of_inputs.empty() ? of_entries : of_inputs;
  JournalRows recording;
  recording.damage = DamageText(items.size(), "entries and inputs", damage);
  for (auto& [id, item] : items) recording.rows.push_back({id, std::move(item)});
  return recording;
} catch (const SQLite::Exception& e) {
  return Unreadable(path, e.what());
}

}  // namespace musher
