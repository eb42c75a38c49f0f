#pragma once
// Until when a request may be sent. A computer that is suspended does not count that time, and its
// timers do not either: a request that waits for a robot in the evening would be sent in the
// morning. This deadline is over by then.
//
// Threads: loop thread only.

#include "musher/transport/event_loop.hpp"

namespace musher::transport {

class Deadline {
 public:
  // The loop must outlive it.
  Deadline(const EventLoop& loop, Duration timeout)
      : loop_(&loop), at_(loop.Now() + timeout), suspended_then_(loop.TimeSuspended()) {}

  // By the loop's time, for a timer.
  Time at() const { return at_; }
  Duration Left() const { return at_ - loop_->Now() - (loop_->TimeSuspended() - suspended_then_); }
  bool IsOver() const { return Left() <= Duration{}; }

 private:
  const EventLoop* loop_;
  Time at_;
  Duration suspended_then_;
};

}  // namespace musher::transport
