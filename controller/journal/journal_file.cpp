#include "musher/controller/journal/journal_file.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/VariadicBind.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
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

// The file was, while it was written.
struct Removed : JournalFile::Trouble {
  using Trouble::Trouble;
};

constexpr int kBusyTimeoutMs =
    1000;  // a reader that recovers the file after a crash locks it shortly
constexpr Duration kQuickCheckWithin = Milliseconds(1000);
constexpr int kStepsBetweenLooks = 1000;  // of SQLite's virtual machine

// Errors that a whole file does not give. The statements are always the same, so a statement that
// cannot be prepared, or that violates a constraint, shows a damaged schema.
bool MeansDamage(int code) {
  switch (code & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_ERROR:
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
      return true;
    default:
      return false;
  }
}

// Runs `work` with SQLite's exceptions sorted into Damaged and the rest.
template <typename Work>
void Sorted(const std::string& path, Work work) {
  try {
    work();
  } catch (const SQLite::Exception& e) {
    if (MeansDamage(e.getErrorCode())) throw Damaged(e.what());
    // By a damaged header, a file that we may write is one of a version that can only be read.
    const bool readonly = (e.getErrorCode() & 0xff) == SQLITE_READONLY;
    if (readonly && access(path.c_str(), W_OK) == 0) throw Damaged(e.what());
    throw JournalFile::Trouble(e.what());
  }
}

std::int64_t Query(SQLite::Database& database, const char* query) {
  return database.execAndGet(query).getInt64();
}

// Creates the tables in an empty database; throws Damaged for any other file but a journal of this
// version.
void EnsureSchema(SQLite::Database& database) {
  const bool empty = Query(database, "SELECT COUNT(*) FROM sqlite_master") == 0;
  if (!empty && Query(database, "PRAGMA application_id") != journal_schema::kApplicationId) {
    throw Damaged("it is not a journal");
  }
  const auto version = Query(database, "PRAGMA user_version");
  if (!empty && version != journal_schema::kVersion) {
    throw Damaged(journal_schema::OtherVersion(version));
  }
  if (!empty) return;
  SQLite::Transaction transaction(database);
  database.exec(journal_schema::kCreate);
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
  } catch (const Removed&) {
    TryWrite(items, lost);
    return Written::kBegunAgain;
  }
}

JournalFile::Written JournalFile::TryWrite(const std::deque<JournalItem>& items,
                                           std::uint64_t lost) {
  try {
    auto written = Written::kAll;
    Sorted(path_, [&] {
      Open();
      written = Insert(items, lost);
    });
    return written;
  } catch (...) {
    if (CloseIfRemoved()) throw Removed("");
    database_.reset();
    throw;
  }
}

void JournalFile::Open() {
  if (database_) return;
  std::error_code ignored;  // opening the file reports the error
  fs::create_directories(fs::path(path_).parent_path(), ignored);
  // SQLite accepts no link in any part of the path then.
  const fs::path folder = fs::canonical(fs::path(path_).parent_path(), ignored);
  if (folder.empty()) throw Trouble(path_ + ": its folder does not exist");
  auto database = std::make_unique<SQLite::Database>(
      folder / fs::path(path_).filename(),
      SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLITE_OPEN_NOFOLLOW, kBusyTimeoutMs);
  EnsureSchema(*database);  // first: a file that is not a journal must not be changed
  if (!std::exchange(checked_, true)) QuickCheck(*database);
  database->exec("PRAGMA journal_mode = WAL");
  database->exec("PRAGMA synchronous = NORMAL");
  database->exec("PRAGMA journal_size_limit = 4194304");  // of the WAL beside it
  next_id_ = Query(*database, journal_schema::kNewest) + 1;
  struct stat info {};
  if (stat(path_.c_str(), &info) != 0) throw Trouble(path_ + " was removed");
  device_ = info.st_dev;
  inode_ = info.st_ino;
  database_ = std::move(database);
}

// Checks the structure of the file, not its rows, which have checksums. What takes longer than
// kQuickCheckWithin is not checked.
void JournalFile::QuickCheck(SQLite::Database& database) {
  auto end = std::chrono::steady_clock::now() + kQuickCheckWithin;
  const auto is_over = [](void* limit) {
    return std::chrono::steady_clock::now() > *static_cast<decltype(end)*>(limit) ? 1 : 0;
  };
  sqlite3_progress_handler(database.getHandle(), kStepsBetweenLooks, is_over, &end);
  std::string found;
  try {
    found = database.execAndGet("PRAGMA quick_check(1)").getString();
  } catch (const SQLite::Exception& e) {
    sqlite3_progress_handler(database.getHandle(), 0, nullptr, nullptr);
    if ((e.getErrorCode() & 0xff) == SQLITE_INTERRUPT) return;
    throw;
  }
  sqlite3_progress_handler(database.getHandle(), 0, nullptr, nullptr);
  if (found != "ok") throw Damaged("quick_check: " + found);
}

void JournalFile::Close() {
  database_.reset();
}

bool JournalFile::CloseIfRemoved() {
  if (!database_) return false;
  struct stat info {};
  const bool exists = stat(path_.c_str(), &info) == 0;
  if (exists && info.st_dev == device_ && info.st_ino == inode_) return false;
  // By their names, these may belong to another journal that is there now.
  int persist = 1;
  sqlite3_file_control(database_->getHandle(), "main", SQLITE_FCNTL_PERSIST_WAL, &persist);
  database_.reset();
  std::error_code ignored;
  for (const char* companion : {"-wal", "-shm"}) {
    if (!exists) fs::remove(path_ + companion, ignored);
  }
  on_moved_(path_ + " was removed, or another volume was mounted there; a new one is begun");
  return true;
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
