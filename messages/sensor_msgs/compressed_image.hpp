#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/CompressedImage: a picture as it would be in a file.
struct CompressedImage {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::CompressedImage_";
  Header header;
  std::string format;  // "jpeg", "png"
  std::vector<std::uint8_t> data;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.format, m.data);
  }
  friend bool operator==(const CompressedImage&, const CompressedImage&) = default;
};

}  // namespace musher::msg
