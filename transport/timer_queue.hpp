#pragma once
// Timers in the order in which they become due; timers due at the same time in order of creation.
// Reads no clock and owns no thread: a loop queries the next wake-up time and passes the current
// time.
//
// Threads: loop thread only. The queue must outlive its handles.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "musher/transport/event_loop.hpp"

namespace musher::transport {

class TimerQueue {
 public:
  // Runs `callback` at `when`; with a `period` above zero periodically, skipping missed periods.
  LoopHandlePtr Add(Time when, Duration period, std::function<void()> callback);

  // When the first timer is due; nullopt if there is none.
  std::optional<Time> NextDue() const;

  // Runs the first timer if it is due at `now`; returns whether one ran.
  bool RunNext(Time now);

  // Every timer becomes due later by `by`, or sooner if it is negative.
  void Shift(Duration by);

 private:
  struct Timer {
    std::uint64_t number;
    Time when;
    Duration period;
    std::function<void()> callback;
  };
  class Handle;
  using Key = std::pair<Time, std::uint64_t>;

  void Insert(const std::shared_ptr<Timer>& timer);

  std::map<Key, std::shared_ptr<Timer>> timers_;
  std::uint64_t next_number_ = 0;
};

}  // namespace musher::transport
