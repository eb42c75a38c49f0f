#pragma once
// How old the samples of one sensor are. A repeated and a late one is refused: what a robot
// believed to see has to get old. How late one came is the age of its stamp beyond that of the
// fastest one, so the clocks need not agree.
//
// A stamp that is far from the clock of those before, in its past or in its future, is wrong, or
// the clock was set: its sample is refused, and the next one begins again with that clock if it
// follows on it. So stamps of any numbers, or of two clocks in turn, make no old sample a new one.
// Pure; one thread.

#include <optional>

#include "musher/base/time.hpp"

namespace musher::navigation {

class SampleAge {
 public:
  // When the sample that has come now was taken. `stamp`: of the message, since the zero of its
  // clock; 0: it has none, and is new. Nullopt: it is refused.
  std::optional<Time> Take(Duration stamp, Time now);
  void Forget();

 private:
  struct Stamped {
    Duration stamp{};
    Time at{};
  };

  bool IsOfOtherClock(Duration stamp, Time now) const;

  std::optional<Stamped> last_;
  std::optional<Duration> offset_;  // from a stamp to our time, of the fastest sample
  std::optional<Stamped> other_;    // the last one, if it was of another clock
};

}  // namespace musher::navigation
