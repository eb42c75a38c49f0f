#pragma once
// Timers in the order they become due; those due at the same time in the order they were made.
// Reads no clock and owns no thread: a loop asks when it must wake up and says what time it is.
//
// Threads: the loop's only. The queue must outlive the handles it gave out.

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
  // Runs `callback` at `when`; with a `period` above zero again and again, without making up for
  // periods that were missed.
  LoopHandlePtr Add(Time when, Duration period, std::function<void()> callback);

  // When the first timer is due; nullopt when there is none.
  std::optional<Time> NextDue() const;

  // Runs the first timer if it is due at `now`; says whether one ran.
  bool RunNext(Time now);

  // Every timer becomes due later by `by`, or sooner when it is negative.
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
