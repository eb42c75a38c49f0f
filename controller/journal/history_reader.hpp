#pragma once
// Reads the journal for callers on the loop, on a thread of its own: one request after the other,
// each with everything that was appended before the request began. While the disk fails, the
// entries that wait in memory stand behind the entries of the file, and the damage says since when.
//
// Threads: loop thread only, except for the reading itself.

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>

#include "musher/controller/journal/journal.hpp"
#include "musher/controller/journal/journal_reader.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

using OnHistory = std::function<void(const Result<JournalReading>&)>;
// Reads the newest `limit` entries with wall_ns >= since_wall_ns; `done` runs once, later, on the
// loop.
using ReadHistory =
    std::function<void(std::int64_t since_wall_ns, std::size_t limit, OnHistory done)>;

// A reading of the file together with the entries that are not written yet, and since when and why
// they are not. Entries in memory are returned also if the file cannot be read.
Result<JournalReading> WithUnwritten(Result<JournalReading> reading,
                                     const UnwrittenEntries& unwritten, std::int64_t since_wall_ns,
                                     std::size_t limit);

class HistoryReader {
 public:
  // The loop must outlive it. No `done` runs after the destructor, which waits for a read under
  // way, but not for a disk that does not answer.
  HistoryReader(transport::EventLoop& loop, const Journal& journal);
  ~HistoryReader();
  HistoryReader(const HistoryReader&) = delete;
  HistoryReader& operator=(const HistoryReader&) = delete;

  // See ReadHistory. Fails with kCodeTargetBusy if too many requests wait.
  void Read(std::int64_t since_wall_ns, std::size_t limit, OnHistory done);

 private:
  struct Request {
    std::int64_t since_wall_ns = 0;
    std::size_t limit = 0;
    OnHistory done;
  };
  struct Shared;  // with the thread
  void ReadNext();
  void OnRead(const Result<JournalReading>& reading);

  transport::EventLoop& loop_;
  const Journal::Access journal_;
  std::deque<Request> requests_;  // the first one is being read
  const std::shared_ptr<Shared> shared_;
};

}  // namespace musher
