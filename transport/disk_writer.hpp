#pragma once
// Disk I/O beside the loop: a thread runs one job after the other, and the loop receives the result
// of each. A stalled disk blocks only this thread.
//
//   loop:    Do(key, work, done) ─▶ queue ─▶ thread: work() ─▶ loop: done(result)
//                                     ▲         │ failed
//                                     └─────────┘ again after `retry_period`
//
// Jobs have keys. Of each key only the last job counts: it replaces a waiting one, and `done` of an
// earlier one is not called any more, even if its work had begun. So the number of keys bounds the
// queue. A failure is reported once; the job is retried until it succeeds, which is reported too,
// or until another job of its key arrives.
//
// Threads: calls from the loop's thread, except Flush(), which may be called from any thread.
// `work` runs on the writer's thread, `done` on the loop, and never after the writer is destroyed.
// `work` must own what it uses: the destructor waits only `timeout` for a stalled disk and then
// leaves the thread running.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::transport {

struct DiskWriterOptions {
  std::string name = "disk";  // of the thread; at most 15 bytes
  int niceness = 0;           // of the thread
  Duration retry_period = Milliseconds(1000);
  Duration timeout = Milliseconds(2000);  // of the destructor
};

class DiskWriter {
 public:
  using Work = std::function<Result<>()>;
  using Done = std::function<void(const Result<>&)>;

  // The loop must outlive the writer.
  explicit DiskWriter(EventLoop& loop, DiskWriterOptions options = {});
  // Runs the waiting jobs first, for at most `timeout`; does not retry a failed job.
  ~DiskWriter();
  DiskWriter(const DiskWriter&) = delete;
  DiskWriter& operator=(const DiskWriter&) = delete;

  void Do(const std::string& key, Work work, Done done = nullptr);

  // Waits until each earlier job has been tried, at most `timeout`; returns whether all succeeded.
  // `done` is called later by the loop.
  bool Flush(Duration timeout);

 private:
  struct Queue;

  static void Run(const std::shared_ptr<Queue>& queue);

  struct Awaited {
    std::uint64_t number = 0;
    Done done;
  };

  void Ended(const std::string& key, std::uint64_t number, const Result<>& result);

  EventLoop& loop_;
  const DiskWriterOptions options_;
  const std::shared_ptr<Queue> queue_;  // shared with the thread
  std::map<std::string, Awaited> awaited_;
  const std::shared_ptr<DiskWriter*>
      alive_;  // expires with the writer; checked by posted callbacks
};

}  // namespace musher::transport
