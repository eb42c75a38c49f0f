#pragma once
// Which pictures are processed. Pure.

#include <cstdint>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/messages/sensor_msgs/image.hpp"

namespace musher::vision {

// rgb8, bgr8, rgba8, bgra8 or mono8, and as many bytes as its size needs. The Error says what is
// wrong.
Result<> CheckPicture(const msg::Image& picture);

// A picture that passed CheckPicture().
struct Shot {
  std::int64_t stamp_ns = 0;  // the picture's; if that is 0, the time of its reception
  msg::Image picture;
};

// By their stamps: no picture twice, none that is late, and no more than the rate.
class StampGate {
 public:
  // 0: every picture.
  explicit StampGate(double rate_hz);

  enum class Verdict {
    kLook,
    kLookAfterJump,  // time jumped back: tracks are void
    kNotNewer,       // not newer than the last one by a millisecond
    kTooSoon,        // earlier than the rate permits
  };
  Verdict Check(std::int64_t stamp_ns);

 private:
  const std::int64_t period_ns_;
  std::optional<std::int64_t> last_ns_;
  std::int64_t due_ns_ = 0;
};

// How many pictures in a row are equal. A live camera has noise in each pixel: equal pictures are
// one that its driver repeats.
class StillPictures {
 public:
  // Counts this one, too: 1 for one that differs from the last. Compares a part of the pixels.
  int Count(const msg::Image& picture);

 private:
  std::optional<std::uint64_t> digest_;  // of the last picture
  int equal_ = 0;
};

}  // namespace musher::vision
