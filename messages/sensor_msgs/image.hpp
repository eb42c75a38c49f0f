#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/Image: a picture as it is in memory, the upper row first.
struct Image {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::Image_";
  Header header;  // when it was taken, and by which camera
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;  // "bgr8", "rgb8", "mono8", …
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;  // bytes of a row
  std::vector<std::uint8_t> data;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.height, m.width, m.encoding, m.is_bigendian, m.step, m.data);
  }
  friend bool operator==(const Image&, const Image&) = default;
};

}  // namespace musher::msg
