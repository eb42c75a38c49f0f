#pragma once
// Finds out that the process of a loop could not run for a while (base/break_watch.hpp): it was
// stopped, or its computer suspended. It counts from its construction on.
//
// Threads: loop thread only.

#include <optional>

#include "musher/base/break_watch.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::transport {

class LoopBreaks {
 public:
  // A break is longer than `shortest`. The loop must outlive it.
  explicit LoopBreaks(EventLoop& loop, Duration shortest = BreakWatch::kShortest)
      : loop_(loop), watch_(shortest) {
    Note();
    timer_ = loop_.Every(shortest / 10, [this] { Note(); });
  }
  LoopBreaks(const LoopBreaks&) = delete;
  LoopBreaks& operator=(const LoopBreaks&) = delete;

  // The length of a break that has ended less than 2 s ago: a request that arrives now may be as
  // old.
  std::optional<Duration> Recent() { return watch_.Recent(loop_.Now(), loop_.TimeSuspended()); }

  // The longest break since the last call, whenever it has ended: each counts once. For what was
  // under way in it.
  std::optional<Duration> Take() { return watch_.Take(loop_.Now(), loop_.TimeSuspended()); }

 private:
  void Note() { watch_.Note(loop_.Now(), loop_.TimeSuspended()); }

  EventLoop& loop_;
  BreakWatch watch_;
  LoopHandlePtr timer_;
};

}  // namespace musher::transport
