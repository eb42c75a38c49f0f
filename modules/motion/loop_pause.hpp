#pragma once
// Whether this process has gone on just now after it stood still: it was suspended, swapped out, or
// hung. What clients requested meanwhile is read then, and they may have given up.
//
// Threads: one at a time. The time is that of the loop.

#include <optional>

#include "musher/base/time.hpp"

namespace musher::motion {

class LoopPause {
 public:
  static constexpr Duration kPeriod = Milliseconds(100);  // of OnTurn(), at most
  static constexpr Duration kLeast = Milliseconds(2000);  // a turn that is less late is only busy
  static constexpr Duration kReads = Milliseconds(1000);  // afterwards what has waited is read

  // In each turn of the loop, and before a request is handled.
  void OnTurn(Time now) {
    if (last_turn_ && now - *last_turn_ >= kLeast) reads_until_ = now + kReads;
    last_turn_ = now;
  }

  // Whether what is read now may have waited.
  bool HasEnded(Time now) const { return reads_until_ && now < *reads_until_; }

 private:
  std::optional<Time> last_turn_;
  std::optional<Time> reads_until_;
};

}  // namespace musher::motion
