#pragma once
// How old the samples of one sensor are. A repeated and a late one is refused: what a robot
// believed to see has to get old. How late one came is the age of its stamp beyond that of the
// fastest one, so the clocks need not agree. One that was set, either way, begins again. Pure; one
// thread.

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
  bool IsNew(Duration stamp, Time now);

  std::optional<Duration> last_stamp_;
  std::optional<Duration> offset_;  // from a stamp to our time, of the fastest sample
  Time last_at_{};
};

}  // namespace musher::navigation
