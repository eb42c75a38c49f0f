#pragma once
// Whether a yellow light stops a movement: a near one does, or one of unknown distance; the same
// one not twice. Pure.
//
// Times are those of the machine. One thread.

#include <optional>

#include "musher/modules/race/perception.hpp"

namespace musher::race {

class LightWatch {
 public:
  explicit LightWatch(const LightRule& rule) : rule_(rule) {}

  // Each tick of a watched movement, with the newest picture of it; null: none. Returns whether
  // the movement has to stop, which then counts as done.
  bool Stops(const Sighting* sighting, Duration now) {
    if (sighting == nullptr) return false;
    if (!sighting->seen) {
      if (!clear_from_) clear_from_ = now;
      if (now - *clear_from_ >= rule_.clear) armed_ = true;
      return false;
    }
    clear_from_.reset();
    if (continued_at_ && now - *continued_at_ >= rule_.again) armed_ = true;
    const bool near = !(sighting->distance_m > rule_.within_m);  // NaN is, for safety
    if (!armed_ || !near) return false;
    armed_ = false;
    continued_at_.reset();
    return true;
  }
  // The pictures between two movements do not count.
  void Interrupt() { clear_from_.reset(); }
  // The stopped movement continues.
  void Continue(Duration now) { continued_at_ = now; }
  void Reset() { *this = LightWatch(rule_); }

  LightWatch(const LightWatch&) = default;
  LightWatch& operator=(const LightWatch& other) {
    armed_ = other.armed_;
    clear_from_ = other.clear_from_;
    continued_at_ = other.continued_at_;
    return *this;
  }
  ~LightWatch() = default;

 private:
  const LightRule& rule_;
  bool armed_ = true;
  std::optional<Duration> clear_from_;    // no light is seen since
  std::optional<Duration> continued_at_;  // after a stop
};

}  // namespace musher::race
