#pragma once
#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher::msg {

// std_msgs/msg/Header
struct Header {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::Header_";
  Stamp stamp;
  std::string frame_id;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.stamp, m.frame_id);
  }
  friend bool operator==(const Header&, const Header&) = default;
};

}  // namespace musher::msg
