#pragma once
// Selects frames so that their rate is limited. By the time a frame was taken, not by when it
// arrived: neither a busy machine nor a world that runs faster than real time changes the rate.
// Pure.

#include <cstdint>
#include <optional>

namespace musher::camera {

class Pace {
 public:
  // 0: every frame.
  explicit Pace(double rate_hz = 0)
      : period_ns_(rate_hz > 0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0) {}

  bool Due(std::int64_t stamp_ns) {
    if (period_ns_ == 0) return true;
    // Also after the world's time jumps back.
    const bool jumped = due_ns_ && stamp_ns < *due_ns_ - 2 * period_ns_;
    if (due_ns_ && !jumped && stamp_ns < *due_ns_ - period_ns_ / kEarlyPart) return false;
    const bool in_step = due_ns_ && !jumped && stamp_ns < *due_ns_ + period_ns_;
    due_ns_ = (in_step ? *due_ns_ : stamp_ns) + period_ns_;
    return true;
  }

 private:
  // A frame that is a little early is taken: its source and this class use two clocks.
  static constexpr std::int64_t kEarlyPart = 4;

  std::int64_t period_ns_;
  std::optional<std::int64_t> due_ns_;
};

}  // namespace musher::camera
