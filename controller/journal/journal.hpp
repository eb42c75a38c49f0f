#pragma once
// The journal records what happened on the robot and why, in a file that survives kill -9 and power
// loss: entries for people, and all inputs of the decision code, so that they can be replayed.
//
// The loop hands both over and continues; a writer thread puts them into a SQLite database (WAL),
// one transaction for all that are queued. An appended item is on disk some milliseconds after
// Append(): kill -9 can lose queued items, a power cut the last transactions; neither damages the
// file.
//
// A disk fault never reaches the robot. It is reported once for each period of trouble; entries
// wait in a bounded queue, from which the oldest are dropped and counted; the writer retries
// periodically, and after success an entry records the number of lost entries. Meanwhile a note
// beside the file says that it lacks entries (journal_gap.hpp): if the controller ends before it
// can write them, the next one records that. A damaged file, or one that is not a journal, is moved
// aside as <path>.damaged-<n> and a new one is created; so is one in place of a file that was
// removed while it was written.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "musher/controller/journal/encoding.hpp"
#include "musher/controller/journal/journal_gap.hpp"

namespace musher {

struct JournalEntry {
  std::int64_t wall_ns = 0;         // since 1970, UTC
  std::int64_t steady_ns = 0;       // of the controller's steady clock; orders entries of one boot
  Epoch epoch = 0;                  // of the controller
  CommandNumber switch_number = 0;  // 0 = not part of a switch
  std::string kind;      // "switch", "command", "exit", ...; "journal" is the journal's own
  std::string actuator;  // empty = the machine
  std::int32_t code = 0;
  std::string message;  // a sentence
  std::string data;     // more, as JSON; may be empty
  RecordId id = 0;      // of the decision's record, grows from 1 in a controller; 0: none
  RecordId cause = 0;   // id of the record that it follows from; 0: none
  State state{};        // the machine's new state, if this entry records its change
  std::string event{};  // its event name; empty: written by an older version, or the journal's own

  friend bool operator==(const JournalEntry&, const JournalEntry&) = default;
};

// An input of the decision code. It precedes the entries that follow from it.
struct JournalInput {
  std::int64_t wall_ns = 0;
  std::variant<recording::ConfigText,   // a machine begins
               recording::TimedEvent,   // a step
               recording::SnapshotPtr>  // a replay can start here
      what;
};

using JournalItem = std::variant<JournalEntry, JournalInput>;

class JournalSink {
 public:
  virtual ~JournalSink() = default;

  // Never blocks on the disk, never fails.
  virtual void Append(JournalItem item) noexcept = 0;
  // Whether a snapshot should come next, because earlier inputs are lost. Reading it resets it.
  virtual bool WantsSnapshot() noexcept { return false; }
};

struct JournalOptions {
  std::int64_t max_bytes = 64 << 20;  // beyond it the oldest tenth goes, up to a snapshot
  std::size_t max_waiting = 10000;    // entries and inputs
  Duration retry_period = Milliseconds(10000);
  Duration look_period = Milliseconds(1000);   // whether the file is still at its path
  Duration stop_timeout = Milliseconds(5000);  // of the destructor, on a disk that does not answer
  // Both run on the writer thread, with no lock held; they may Append(), but must not throw or
  // Flush(). `on_moved` receives what happened to a damaged file.
  std::function<void(const std::string&)> on_moved;
  // Called when writing begins to fail, with the reason, and when it works again.
  std::function<void(const Result<>&)> on_writing;
};

// What is not in the file.
struct UnwrittenEntries {
  std::vector<JournalEntry> entries;  // that wait, oldest first
  std::uint64_t lost = 0;             // dropped because the queue was full; older than `entries`
  std::optional<JournalGap> gap;      // none: a write is only slow
};

class Journal : public JournalSink {
  class Writer;

 public:
  // For a thread that reads the file; also after the journal is destroyed. From any thread.
  class Access {
   public:
    explicit Access(std::shared_ptr<Writer> writer) : writer_(std::move(writer)) {}
    const std::string& path() const;
    bool Flush(Duration timeout) const;  // as Journal::Flush()
    UnwrittenEntries Unwritten() const;  // as Journal::Unwritten()

   private:
    std::shared_ptr<Writer> writer_;
  };

  // Opens nothing itself: the writer thread opens the file and creates it, with its folder if
  // needed.
  Journal(std::string path, JournalOptions options);
  // Tries once more to write the queued items. A writer that a disk holds for longer than
  // `stop_timeout` is left to itself; no callback runs any more.
  ~Journal() override;

  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Callable from any thread.
  void Append(JournalItem item) noexcept override;
  bool WantsSnapshot() noexcept override;

  const std::string& path() const { return path_; }

  // Waits until everything appended before is written, at most `timeout`; returns whether it is. In
  // trouble it makes the writer retry at once and returns after that attempt. From any thread
  // except the loop's, which must not wait for a disk while the robot runs.
  bool Flush(Duration timeout) { return access().Flush(timeout); }
  // After a Flush() in vain. Without the entries of a write that is under way. From any thread.
  UnwrittenEntries Unwritten() const { return access().Unwritten(); }
  Access access() const { return Access(writer_); }

 private:
  const std::string path_;
  const std::shared_ptr<Writer> writer_;  // shared with its thread
};

}  // namespace musher
