#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// std_msgs/msg/String
struct String {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::String_";
  std::string data;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const String&, const String&) = default;
};

}  // namespace musher::msg
