#pragma once
// Which pictures are looked at. Pure.

#include <cstdint>
#include <optional>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/messages/sensor_msgs/image.hpp"

namespace musher::vision {

// rgb8, bgr8, rgba8, bgra8 or mono8, and as many bytes as its size says. The Error says what is
// wrong with it.
Result<> CheckPicture(const msg::Image& picture);

// By their stamps: none twice, none that comes late, and not more of them than asked for.
class StampGate {
 public:
  // 0: every picture.
  explicit StampGate(double rate_hz);

  enum class Verdict {
    kLook,
    kLookAnew,  // time has jumped back: what is remembered is of another time
    kNotNewer,  // than the last one that was looked at, by a millisecond
    kTooSoon,   // for the rate
  };
  Verdict Judge(std::int64_t stamp_ns);

 private:
  const std::int64_t period_ns_;
  std::optional<std::int64_t> last_ns_;
  std::int64_t due_ns_ = 0;
};

}  // namespace musher::vision
