#pragma once
// Disk IO beside the loop: a thread does it, one job after the other, and the loop receives how
// each ended. A disk that stalls holds up this thread and nothing else.
//
//   loop:    Do(key, work, done) ─▶ queue ─▶ thread: work() ─▶ loop: done(result)
//                                     ▲         │ failed
//                                     └─────────┘ again after `retry_period`
//
// Jobs have keys. Of one key only the last job counts: it takes the place of one that waits, and
// `done` of an earlier one is not called any more, also when its work had begun. So the queue is
// bounded by the number of keys. A failure is reported once; the job is tried again until it works,
// which is reported too, or until another one of its key comes.
//
// Threads: calls from the loop's thread, but Flush(), which may come from any. `work` runs on the
// writer's thread, `done` on the loop, and never after the writer is destroyed. What `work` uses
// has to live as long as `work` itself does: the destructor waits for a stalled disk for a while
// only, and leaves the thread to itself then.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

struct DiskWriterOptions {
  std::string name = "disk";  // of the thread; at most 15 bytes
  int niceness = 0;           // of the thread
  Duration retry_period = Milliseconds(1000);
  Duration patience = Milliseconds(2000);  // of the destructor
};

class DiskWriter {
 public:
  using Work = std::function<Result<>()>;
  using Done = std::function<void(const Result<>&)>;

  // The loop must outlive the writer.
  explicit DiskWriter(transport::EventLoop& loop, DiskWriterOptions options = {});
  // What waits is done before, as far as the patience goes; a job that fails is not tried again.
  ~DiskWriter();
  DiskWriter(const DiskWriter&) = delete;
  DiskWriter& operator=(const DiskWriter&) = delete;

  void Do(const std::string& key, Work work, Done done = nullptr);

  // Waits until each job that was handed over before has been tried, at most `timeout`; says
  // whether all have worked. `done` is called when the loop comes to it.
  bool Flush(Duration timeout);

 private:
  struct Queue;

  static void Run(const std::shared_ptr<Queue>& queue);

  struct Awaited {
    std::uint64_t number = 0;
    Done done;
  };

  void Ended(const std::string& key, std::uint64_t number, const Result<>& result);

  transport::EventLoop& loop_;
  const DiskWriterOptions options_;
  const std::shared_ptr<Queue> queue_;  // shared with the thread
  std::map<std::string, Awaited> awaited_;
  const std::shared_ptr<DiskWriter*> alive_;  // for what the thread posts: expires with the writer
};

}  // namespace musher
