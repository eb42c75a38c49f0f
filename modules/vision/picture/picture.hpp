#pragma once
// Which pictures are processed. Pure.

#include <array>
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

// How long the pictures are old ones. A live camera has noise in each pixel: equal pictures are one
// that its driver repeats, or a ring of buffers.
class StillPictures {
 public:
  // By the stamps; 0 for a picture that differs from the last kBuffers different ones. Compares a
  // part of the pixels.
  Duration StillFor(const msg::Image& picture, std::int64_t stamp_ns);

 private:
  static constexpr std::size_t kBuffers = 4;

  std::array<std::optional<std::uint64_t>, kBuffers> digests_;  // of different pictures
  std::size_t oldest_ = 0;
  std::int64_t changed_ns_ = 0;  // the stamp of the last picture that differs
};

}  // namespace musher::vision
