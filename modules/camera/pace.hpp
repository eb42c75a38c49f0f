#pragma once
// Which of many frames are to be taken, so that they are at most so many a second. By the time a
// frame was taken, not by when it came: neither a busy machine nor a world that goes faster than
// ours changes how many a second there are. Pure.

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
    // After a jump back of the world's time, too.
    const bool jumped = due_ns_ && stamp_ns < *due_ns_ - 2 * period_ns_;
    if (due_ns_ && !jumped && stamp_ns < *due_ns_ - period_ns_ / kEarlyPart) return false;
    const bool in_step = due_ns_ && !jumped && stamp_ns < *due_ns_ + period_ns_;
    due_ns_ = (in_step ? *due_ns_ : stamp_ns) + period_ns_;
    return true;
  }

 private:
  // A frame that comes a little early is taken: what paces it and what paces us are two clocks.
  static constexpr std::int64_t kEarlyPart = 4;

  std::int64_t period_ns_;
  std::optional<std::int64_t> due_ns_;
};

}  // namespace musher::camera
