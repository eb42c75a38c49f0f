#pragma once
// Finds out that a process could not run for a while: it was stopped, or its computer suspended.
// What was sent to it meanwhile has waited in the kernel, or is repeated by its writer, and arrives
// in the two seconds after that, however old it is.
//
// Pure. `suspended`: how long the computer was suspended since its boot, which `now` does not
// count. transport/loop_breaks.hpp has the one of a loop.

#include <algorithm>
#include <optional>
#include <utility>

#include "musher/base/time.hpp"

namespace musher {

class BreakWatch {
 public:
  static constexpr Duration kShortest = std::chrono::seconds(5);
  static constexpr Duration kArriveWithin = std::chrono::seconds(2);  // a repetition takes 1 s
  // What was under way before a longer one does not go on by itself, as after a restart.
  static constexpr Duration kLong = std::chrono::minutes(1);

  // A break is longer than `shortest`; what it has delayed arrives within `arrive_within` after it.
  explicit BreakWatch(Duration shortest = kShortest, Duration arrive_within = kArriveWithin)
      : shortest_(shortest), arrive_within_(arrive_within) {}

  // The process runs. The owner calls it several times in `shortest`: the time since the last call
  // counts as part of a break.
  void Note(Time now, Duration suspended) {
    const Duration silent = noted_ ? now - *noted_ + (suspended - suspended_then_) : Duration{};
    noted_ = now;
    suspended_then_ = suspended;
    if (silent <= shortest_) return;
    length_ = silent;
    not_taken_ = std::max(not_taken_.value_or(Duration{}), silent);
    counts_until_ = now + arrive_within_;
  }

  // The length of a break that has ended less than `arrive_within` ago. A request that arrives now
  // may be as old.
  std::optional<Duration> Recent(Time now, Duration suspended) {
    Note(now, suspended);  // perhaps the owner's timer comes after the request
    return now < counts_until_ ? std::optional(length_) : std::nullopt;
  }

  // The longest break since the last call, whenever it has ended: each counts once. For what was
  // under way in it.
  std::optional<Duration> Take(Time now, Duration suspended) {
    Note(now, suspended);
    return std::exchange(not_taken_, std::nullopt);
  }

 private:
  Duration shortest_;
  Duration arrive_within_;
  std::optional<Time> noted_;
  Duration suspended_then_{};
  Duration length_{};  // of the last break
  std::optional<Duration> not_taken_;
  Time counts_until_{};
};

}  // namespace musher
