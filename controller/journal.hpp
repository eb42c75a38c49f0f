#pragma once
// What happened on the robot and why, in a file that survives kill -9 and power loss: entries for
// people, and all that went into the decision code, so that it can be run again (replay).
//
// The loop hands both over and goes on; a writer thread puts them into a SQLite database (WAL),
// one transaction for all that have gathered. What is appended is on disk some milliseconds after
// Append(): kill -9 can lose those that were still in the queue, a power cut the last transactions;
// neither damages the file.
//
// Nothing that goes wrong with the disk reaches the robot. It is said once for each spell of
// trouble; entries wait in a bounded queue, from which the oldest are dropped and counted; writing
// is tried again now and then, and when it works the number of lost entries becomes an entry. A
// damaged file, or one that is not a journal, is moved aside as <path>.damaged-<n> and a new one is
// begun.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "musher/controller/recording/encoding.hpp"

namespace musher {

struct JournalEntry {
  std::int64_t wall_ns = 0;         // since 1970, UTC
  std::int64_t steady_ns = 0;       // of the controller's steady clock; orders entries of one boot
  std::uint64_t epoch = 0;          // of the controller
  std::uint64_t switch_number = 0;  // 0 = not part of a switch
  std::string kind;      // "switch", "command", "exit", ...; "journal" is the journal's own
  std::string actuator;  // empty = the machine
  std::int32_t code = 0;
  std::string message;      // a sentence
  std::string data;         // more, as JSON; may be empty
  std::uint64_t id = 0;     // of the decision's record, grows from 1 in a controller; 0: none
  std::uint64_t cause = 0;  // id of the record that it follows from; 0: none
  State state{};            // the machine's, where this entry tells that it has changed

  friend bool operator==(const JournalEntry&, const JournalEntry&) = default;
};

// Something that goes into the decision code. It comes before the entries that it leads to.
struct JournalInput {
  std::int64_t wall_ns = 0;
  std::variant<recording::ConfigText,   // a machine begins
               recording::TimedEvent,   // a step
               recording::SnapshotPtr>  // from here on it can be run again without what was before
      what;
};

using JournalItem = std::variant<JournalEntry, JournalInput>;

class JournalSink {
 public:
  virtual ~JournalSink() = default;

  // Never blocks on the disk, never fails.
  virtual void Append(JournalItem item) noexcept = 0;
  // Whether a snapshot should come next, because what was before it is lost. Asked once each time.
  virtual bool WantsSnapshot() noexcept { return false; }
};

struct JournalOptions {
  std::int64_t max_bytes = 64 << 20;  // beyond it the oldest tenth goes, up to a snapshot
  std::size_t max_waiting = 10000;    // entries and inputs
  Duration retry_period = Milliseconds(10000);
  // Told what is wrong, and what became of it. Runs on the writer thread, with no lock held; it may
  // Append(), but must not throw or Flush().
  std::function<void(const std::string&)> on_trouble;
};

class Journal : public JournalSink {
 public:
  // Opens nothing itself: the file is opened and created, if need be with its folder, by the writer
  // thread.
  Journal(std::string path, JournalOptions options);
  // Tries once more to write what waits.
  ~Journal() override;

  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // From any thread.
  void Append(JournalItem item) noexcept override;
  bool WantsSnapshot() noexcept override;

  const std::string& path() const { return path_; }

  // Waits until everything appended before is written, at most `timeout`; says whether it is. In
  // trouble it makes the writer try again at once and ends with that attempt. From any thread but
  // the loop's, which must not wait for a disk while the robot runs.
  bool Flush(Duration timeout);

 private:
  class Writer;
  const std::string path_;
  std::unique_ptr<Writer> writer_;
};

}  // namespace musher
