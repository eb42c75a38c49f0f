#pragma once
// Reads the journal for callers on the loop, on a thread of its own: one reading after the other,
// each with all that was appended before it began, if the disk is well.
//
// Threads: loop thread only, but for the reading itself.

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <thread>

#include "musher/controller/journal.hpp"
#include "musher/controller/journal_reader.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

using OnHistory = std::function<void(const Result<JournalReading>&)>;
// Reads the newest `limit` entries with wall_ns >= since_wall_ns; `done` runs once, on the loop,
// later.
using ReadHistory =
    std::function<void(std::int64_t since_wall_ns, std::size_t limit, OnHistory done)>;

class HistoryReader {
 public:
  // Both must outlive it. Its end waits for the reading under way; no `done` runs after it.
  HistoryReader(transport::EventLoop& loop, Journal& journal) : loop_(loop), journal_(journal) {}

  // See ReadHistory. Refused with kCodeTargetBusy when many wait already.
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
