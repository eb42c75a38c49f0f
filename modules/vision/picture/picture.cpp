#include "musher/modules/vision/picture/picture.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "musher/modules/vision/picture/vision_code.hpp"

namespace musher::vision {
namespace {

constexpr std::array<std::pair<std::string_view, std::uint32_t>, 5> kEncodings = {
    {{"rgb8", 3}, {"bgr8", 3}, {"rgba8", 4}, {"bgra8", 4}, {"mono8", 1}}};
constexpr std::uint32_t kMostPx = 8192;     // of a side
constexpr std::size_t kSampledStride = 61;  // bytes; a prime, so that no column is sampled alone
constexpr std::int64_t kNewerNs = 1'000'000;
constexpr std::int64_t kJumpNs = 1'000'000'000;  // no picture is later than this

Error Fault(const std::string& what) {
  return {VisionCode(KeyCode::kParametersInvalid), what};
}

std::string Printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

}  // namespace

Result<> CheckPicture(const msg::Image& picture) {
  std::uint32_t channels = 0;
  for (const auto& [name, count] : kEncodings) {
    if (picture.encoding == name) channels = count;
  }
  if (channels == 0) {
    return Fault("pictures are rgb8, bgr8, rgba8, bgra8 or mono8, this one is '" +
                 Printable(picture.encoding.substr(0, 20)) + "'");
  }
  const std::string size = std::to_string(picture.width) + " x " + std::to_string(picture.height);
  if (picture.width == 0 || picture.height == 0 || picture.width > kMostPx ||
      picture.height > kMostPx) {
    return Fault("a picture of " + size + " pixels");
  }
  if (picture.step < picture.width * channels) {
    return Fault("a row of " + std::to_string(picture.step) + " bytes in a picture of " + size);
  }
  if (picture.data.size() != std::size_t{picture.step} * picture.height) {
    return Fault(std::to_string(picture.data.size()) + " bytes of a picture of " + size + " with " +
                 std::to_string(picture.step) + " in a row");
  }
  return Ok();
}

Duration StillPictures::StillFor(const msg::Image& picture, std::int64_t stamp_ns) {
  std::uint64_t digest = 0xcbf29ce484222325;  // FNV-1a
  const auto add = [&digest](std::uint64_t word) { digest = (digest ^ word) * 0x100000001b3; };
  add(picture.width);
  add(picture.height);
  for (std::size_t i = 0; i < picture.data.size(); i += kSampledStride) add(picture.data[i]);
  const bool is_old = std::ranges::find(digests_, std::optional(digest)) != digests_.end();
  if (!is_old) {
    digests_[oldest_] = digest;
    oldest_ = (oldest_ + 1) % kBuffers;
  }
  if (!is_old || stamp_ns < changed_ns_) changed_ns_ = stamp_ns;
  return Duration(stamp_ns - changed_ns_);
}

StampGate::StampGate(double rate_hz)
    : period_ns_(rate_hz > 0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0) {}

StampGate::Verdict StampGate::Check(std::int64_t stamp_ns) {
  const bool jumped = last_ns_ && stamp_ns < *last_ns_ - kJumpNs;
  if (last_ns_ && !jumped) {
    if (stamp_ns < *last_ns_ + kNewerNs) return Verdict::kNotNewer;
    // A picture that is a little early is taken: the camera has its own clock.
    if (stamp_ns < due_ns_ - period_ns_ / 4) return Verdict::kTooSoon;
  }
  const bool in_step = last_ns_ && !jumped && stamp_ns < due_ns_ + period_ns_;
  due_ns_ = (in_step ? due_ns_ : stamp_ns) + period_ns_;
  last_ns_ = stamp_ns;
  return jumped ? Verdict::kLookAfterJump : Verdict::kLook;
}

}  // namespace musher::vision
