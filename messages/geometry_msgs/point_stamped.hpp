#pragma once
#include "musher/messages/geometry_msgs/geometry.hpp"

namespace musher::msg {

// geometry_msgs/msg/PointStamped: in the frame of its header.
struct PointStamped {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::PointStamped_";
  Header header;
  Point point;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.point);
  }
  friend bool operator==(const PointStamped&, const PointStamped&) = default;
};

}  // namespace musher::msg
