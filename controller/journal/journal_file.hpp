#pragma once
// The journal's database (journal.hpp): its tables, its size limit, and the handling of a damaged
// file. Only the journal's writer thread uses it.

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "musher/controller/journal/journal.hpp"

namespace SQLite {
class Database;
}

namespace musher {

class JournalFile {
 public:
  // Why the file could not be opened or written.
  struct Trouble : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  // Calls `on_moved` when a file that is not (or no longer) a journal was moved aside.
  JournalFile(std::string path, std::int64_t max_bytes,
              std::function<void(const std::string&)> on_moved);
  ~JournalFile();

  void Close();

  // Whether the open file is no longer at its path: it was removed, or another volume is mounted
  // there. It is then closed, and the next Write() opens or creates the one at the path.
  bool CloseIfRemoved();

  enum class Written {
    kAll,
    kNoSnapshotLeft,  // the file was trimmed, and no replay can start in the rest
    kBegunAgain,      // as after CloseIfRemoved(): the file was removed while it was written
  };

  // Writes the items in one transaction: all or none. `lost` items are missing before the first.
  // Opens or creates the file if it is not open. Throws Trouble; the next call then reopens the
  // file.
  Written Write(const std::deque<JournalItem>& items, std::uint64_t lost);

 private:
  Written TryWrite(const std::deque<JournalItem>& items, std::uint64_t lost);
  void Open();
  Written Insert(const std::deque<JournalItem>& items, std::uint64_t lost);
  Written Trim();
  void MoveAside(const std::string& why);
  void QuickCheck(SQLite::Database& database);

  const std::string path_;
  const std::int64_t max_bytes_;
  const std::function<void(const std::string&)> on_moved_;
  std::unique_ptr<SQLite::Database> database_;
  dev_t device_ = 0;  // of the open file
  ino_t inode_ = 0;
  bool checked_ = false;      // the file that a controller before this one has left
  std::int64_t next_id_ = 1;  // of an entry or an input, while the file is open
};

}  // namespace musher
