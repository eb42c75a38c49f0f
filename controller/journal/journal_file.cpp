#include "musher/controller/journal/journal_file.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/VariadicBind.h>
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <utility>
#include <variant>

#include "musher/controller/journal/journal_checksum.hpp"
#include "musher/controller/journal/journal_schema.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// The file is not a journal, or no longer one.
struct Damaged : JournalFile::Trouble {
  using Trouble::Trouble;
};

constexpr int kBusyTimeoutMs =
    1000;  // a reader that recovers the file after a crash locks it shortly

// Runs `work` with SQLite's exceptions sorted into Damaged and the rest.
template <typename Work>
void Sorted(Work work) {
  try {
    work();
  } catch (const SQLite::Exception& e) {
    const int code = e.getErrorCode() & 0xff;
    if (code == SQLITE_CORRUPT || code == SQLITE_NOTADB) throw Damaged(e.what());
    throw JournalFile::Trouble(e.what());
  }
}

std::int64_t Query(SQLite::Database& database, const char* query) {
  return database.execAndGet(query).getInt64();
}

// Creates the tables in an empty database and upgrades an older journal; throws Damaged for any
// other file.
void EnsureSchema(SQLite::Database& database) {
  const bool empty = Query(database, "SELECT COUNT(*) FROM sqlite_master") == 0;
  if (!empty && Query(database, "PRAGMA application_id") != journal_schema::kApplicationId) {
    throw Damaged("it is not a journal");
  }
  const auto version = empty ? 0 : Query(database, "PRAGMA user_version");
  if (version == journal_schema::kVersion) return;
  if (!empty && version != 1 && version != 2) {
    throw Damaged("its version is " + std::to_string(version) + ", not " +
                  std::to_string(journal_schema::kVersion));
  }
  SQLite::Transaction transaction(database);
  if (empty) database.exec(journal_schema::kCreateVersion1);
  if (version < 2) database.exec(journal_schema::kUpgradeTo2);
  database.exec(journal_schema::kUpgradeTo3);
  database.exec("PRAGMA application_id = " + std::to_string(journal_schema::kApplicationId));
  database.exec("PRAGMA user_version = " + std::to_string(journal_schema::kVersion));
  transaction.commit();
}

// One row of either table.
class Inserter {
 public:
  explicit Inserter(SQLite::Database& database)
      : entry_(database, journal_schema::kInsertEntry),
        input_(database, journal_schema::kInsertInput) {}

  void Insert(std::int64_t id, const JournalEntry& e) {
    SQLite::bind(entry_, id, e.wall_ns, e.steady_ns, static_cast<std::int64_t>(e.epoch.value()),
                 static_cast<std::int64_t>(e.switch_number.value()), e.kind, e.actuator, e.code,
                 e.message, e.data, static_cast<std::int64_t>(e.id.value()),
                 static_cast<std::int64_t>(e.cause.value()), e.state, ChecksumOf(id, e), e.event);
    entry_.exec();
    entry_.reset();
  }

  void Insert(std::int64_t id, const JournalInput& input) {
    const auto [kind, data] = std::visit(Encode{}, input.what);
    SQLite::bind(input_, id, input.wall_ns, kind, data, ChecksumOf(id, input.wall_ns, kind, data));
    input_.exec();
    input_.reset();
  }

 private:
  struct Encode {
    using Row = std::pair<std::string, std::string>;
    Row operator()(const recording::ConfigText& config) const {
      return {"config", recording::EncodeConfig(config)};
    }
    Row operator()(const recording::TimedEvent& event) const {
      return {"event", recording::EncodeEvent(event.event, event.now)};
    }
    Row operator()(const recording::SnapshotPtr& snapshot) const {
      return {"machine", recording::EncodeSnapshot(*snapshot)};
    }
  };

  SQLite::Statement entry_;
  SQLite::Statement input_;
};

}  // namespace

JournalFile::JournalFile(std::string path, std::int64_t max_bytes,
                         std::function<void(const std::string&)> on_moved)
    : path_(std::move(path)), max_bytes_(max_bytes), on_moved_(std::move(on_moved)) {}

JournalFile::~JournalFile() = default;

JournalFile::Written JournalFile::Write(const std::deque<JournalItem>& items, std::uint64_t lost) {
  try {
    return TryWrite(items, lost);
  } catch (const Damaged& damaged) {
    MoveAside(damaged.what());
    TryWrite(items, lost);
    return Written::kNoSnapshotLeft;
  }
}

JournalFile::Written JournalFile::TryWrite(const std::deque<JournalItem>& items,
                                           std::uint64_t lost) {
  try {
    auto written = Written::kAll;
    Sorted([&] {
      Open();
      written = Insert(items, lost);
    });
    return written;
  } catch (...) {
    database_.reset();
    throw;
  }
}

void JournalFile::Open() {
  if (database_) return;
  std::error_code ignored;  // opening the file reports the error
  fs::create_directories(fs::path(path_).parent_path(), ignored);
  auto database = std::make_unique<SQLite::Database>(
      path_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kBusyTimeoutMs);
  EnsureSchema(*database);  // first: a file that is not a journal must not be changed
  database->exec("PRAGMA journal_mode = WAL");
  database->exec("PRAGMA synchronous = NORMAL");
  database->exec("PRAGMA journal_size_limit = 4194304");  // of the WAL beside it
  next_id_ = Query(*database, journal_schema::kNewest) + 1;
  database_ = std::move(database);
}

JournalFile::Written JournalFile::Insert(const std::deque<JournalItem>& items, std::uint64_t lost) {
  SQLite::Transaction transaction(*database_);
  Inserter inserter(*database_);
  next_id_ += static_cast<std::int64_t>(lost);
  for (const JournalItem& item : items) {
    std::visit([&](const auto& it) { inserter.Insert(next_id_++, it); }, item);
  }
  const Written written = Trim();
  transaction.commit();
  return written;
}

// SQLite reuses freed pages, so the file stays near its limit without compaction. The rest begins
// with a snapshot if there is one in the older half.
JournalFile::Written JournalFile::Trim() {
  const auto page_size = Query(*database_, "PRAGMA page_size");
  const auto used = [&] {
    const auto pages = Query(*database_, "PRAGMA page_count");
    return page_size * (pages - Query(*database_, "PRAGMA freelist_count"));
  };
  Written written = Written::kAll;
  while (used() > max_bytes_) {
    const auto first = Query(*database_, journal_schema::kOldest);
    const auto last = Query(*database_, journal_schema::kNewest);
    if (first >= last) return written;  // keeps the last row
    auto until = first + std::max<std::int64_t>(1, (last - first) / 10);
    SQLite::Statement next_start(*database_, journal_schema::kNextStart);
    next_start.bind(1, until);
    next_start.executeStep();
    const auto start = next_start.getColumn(0).getInt64();
    next_start.reset();
    written = start == 0 ? Written::kNoSnapshotLeft : Written::kAll;
    if (start != 0 && start - first <= (last - first) / 2) until = start;
    for (const char* query : {journal_schema::kTrimEntry, journal_schema::kTrimInput}) {
      SQLite::Statement remove(*database_, query);
      remove.bind(1, until);
      remove.exec();
    }
  }
  return written;
}

void JournalFile::MoveAside(const std::string& why) {
  std::error_code error;
  if (!fs::is_regular_file(path_, error)) throw Trouble(why);
  std::string aside;
  int n = 0;
  do {
    aside = path_ + ".damaged-" + std::to_string(++n);
  } while (fs::exists(aside, error));
  fs::rename(path_, aside, error);
  if (error) throw Trouble(why + "; it can't be moved aside: " + error.message());
  for (const char* companion : {"-wal", "-shm"}) {
    std::error_code absent;
    fs::rename(path_ + companion, aside + companion, absent);
  }
  on_moved_(path_ + " is damaged (" + why + "); moved to " + aside + ", a new one is created");
}

}  // namespace musher
