#include "musher/controller/journal_file.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/VariadicBind.h>
#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/controller/journal_schema.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// The file is not a journal, or no longer one.
struct Damaged : JournalFile::Trouble {
  using Trouble::Trouble;
};

constexpr int kBusyTimeoutMs =
    1000;  // a reader that recovers the file after a crash holds it shortly

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

std::int64_t Ask(SQLite::Database& database, const char* query) {
  return database.execAndGet(query).getInt64();
}

// Makes an empty database a journal; throws Damaged if it is something else.
void EnsureSchema(SQLite::Database& database) {
  if (Ask(database, "SELECT COUNT(*) FROM sqlite_master") == 0) {
    SQLite::Transaction transaction(database);
    database.exec(journal_schema::kCreate);
    database.exec("PRAGMA application_id = " + std::to_string(journal_schema::kApplicationId));
    database.exec("PRAGMA user_version = " + std::to_string(journal_schema::kVersion));
    transaction.commit();
    return;
  }
  if (Ask(database, "PRAGMA application_id") != journal_schema::kApplicationId) {
    throw Damaged("it is not a journal");
  }
  const auto version = Ask(database, "PRAGMA user_version");
  if (version != journal_schema::kVersion) {
    throw Damaged("its version is " + std::to_string(version) + ", not " +
                  std::to_string(journal_schema::kVersion));
  }
}

}  // namespace

JournalFile::JournalFile(std::string path, std::int64_t max_bytes,
                         std::function<void(const std::string&)> on_moved)
    : path_(std::move(path)), max_bytes_(max_bytes), on_moved_(std::move(on_moved)) {}

JournalFile::~JournalFile() = default;

void JournalFile::Write(const std::deque<JournalEntry>& entries) {
  try {
    TryWrite(entries);
  } catch (const Damaged& damaged) {
    MoveAside(damaged.what());
    TryWrite(entries);
  }
}

void JournalFile::TryWrite(const std::deque<JournalEntry>& entries) {
  try {
    Sorted([&] {
      Open();
      Insert(entries);
    });
  } catch (...) {
    database_.reset();
    throw;
  }
}

void JournalFile::Open() {
  if (database_) return;
  std::error_code ignored;  // the open says what is wrong
  fs::create_directories(fs::path(path_).parent_path(), ignored);
  auto database = std::make_unique<SQLite::Database>(
      path_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kBusyTimeoutMs);
  EnsureSchema(*database);  // first: a file that is not ours is not to be changed
  database->exec("PRAGMA journal_mode = WAL");
  database->exec("PRAGMA synchronous = NORMAL");
  database->exec("PRAGMA journal_size_limit = 4194304");  // of the WAL beside it
  database_ = std::move(database);
}

void JournalFile::Insert(const std::deque<JournalEntry>& entries) {
  SQLite::Transaction transaction(*database_);
  SQLite::Statement insert(*database_, journal_schema::kInsert);
  for (const auto& entry : entries) {
    SQLite::bind(insert, entry.wall_ns, entry.steady_ns, static_cast<std::int64_t>(entry.epoch),
                 static_cast<std::int64_t>(entry.switch_number), entry.kind, entry.actuator,
                 entry.code, entry.message, entry.data);
    insert.exec();
    insert.reset();
  }
  Trim();
  transaction.commit();
}

// Freed pages are used again, so the file stays near its limit without ever being compacted.
void JournalFile::Trim() {
  const auto page_size = Ask(*database_, "PRAGMA page_size");
  const auto used = [&] {
    const auto pages = Ask(*database_, "PRAGMA page_count");
    return page_size * (pages - Ask(*database_, "PRAGMA freelist_count"));
  };
  while (used() > max_bytes_) {
    const auto first = Ask(*database_, "SELECT COALESCE(MIN(id), 0) FROM entry");
    const auto last = Ask(*database_, "SELECT COALESCE(MAX(id), 0) FROM entry");
    if (first == last) return;  // one entry always stays
    const auto until = first + std::max<std::int64_t>(1, (last - first) / 10);
    SQLite::Statement remove(*database_, "DELETE FROM entry WHERE id < ?");
    remove.bind(1, until);
    remove.exec();
  }
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
  on_moved_(path_ + " is damaged (" + why + "); it is kept as " + aside + ", a new one is begun");
}

}  // namespace musher
