#pragma once
// A picture that says when it was taken and which one it is.

#include <cstdint>
#include <cstring>

#include "musher/base/time.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::benchmark {

inline msg::Image MakePicture(std::uint32_t width, std::uint32_t height) {
  msg::Image picture;
  picture.header.frame_id = "camera";
  picture.width = width;
  picture.height = height;
  picture.encoding = "bgr8";
  picture.step = width * 3;
  picture.data.resize(std::size_t{picture.step} * height);
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    picture.data[i] = static_cast<std::uint8_t>(i * 31 >> 3);
  }
  return picture;
}

inline void WriteNumber(msg::Image& picture, std::uint32_t number) {
  std::memcpy(picture.data.data(), &number, sizeof(number));
}
inline std::uint32_t ReadNumber(const msg::Image& picture) {
  std::uint32_t number = 0;
  if (picture.data.size() >= sizeof(number)) {
    std::memcpy(&number, picture.data.data(), sizeof(number));
  }
  return number;
}

// The steady clock, which the processes of a host share.
inline msg::Stamp StampNow() {
  return msg::ToStamp(std::chrono::steady_clock::now().time_since_epoch());
}
inline Duration Age(const msg::Image& picture) {
  return std::chrono::steady_clock::now().time_since_epoch() - msg::FromStamp(picture.header.stamp);
}

}  // namespace musher::benchmark
