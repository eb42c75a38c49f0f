#pragma once
// Reads the journal for callers on the loop, on a thread of its own: one request after the other,
// each with everything that was appended before it began. While the disk fails, the entries that
// wait in memory stand behind those of the file, and the damage says since when.
//
// Threads: loop thread only, except for the reading itself.

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <thread>

#include "musher/controller/journal/journal.hpp"
#include "musher/controller/journal/journal_reader.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

using OnHistory = std::function<void(const Result<JournalReading>&)>;
// Reads the newest `limit` entries with wall_ns >= since_wall_ns; `done` runs once, later, on the
// loop.
using ReadHistory =
    std::function<void(std::int64_t since_wall_ns, std::size_t limit, OnHistory done)>;

// A reading of the file with the entries that are not in it yet, and since when and why they are
// not. What is only in memory is there also if the file cannot be read.
Result<JournalReading> WithUnwritten(Result<JournalReading> reading,
                                     const UnwrittenEntries& unwritten, std::int64_t since_wall_ns,
                                     std::size_t limit);

class HistoryReader {
 public:
  // Both must outlive it. The destructor waits for the running read; no `done` runs after it.
  HistoryReader(transport::EventLoop& loop, Journal& journal) : loop_(loop), journal_(journal) {}

  // See ReadHistory. Fails with kCodeTargetBusy if too many requests wait.
  void Read(std::int64_t since_wall_ns, std::size_t limit, OnHistory done);

 private:
  struct Request {
    std::int64_t since_wall_ns = 0;
    std::size_t limit = 0;
    OnHistory done;
  };
  void ReadNext();

  transport::EventLoop& loop_;
  Journal& journal_;
  std::deque<Request> requests_;  // the first one is being read
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  std::jthread thread_;
};

}  // namespace musher
