#pragma once
#include "musher/messages/geometry_msgs/geometry.hpp"

namespace musher::msg {

// nav_msgs/msg/Odometry: where a body is and how it moves.
struct Odometry {
  static constexpr std::string_view kTypeName = "nav_msgs::msg::dds_::Odometry_";
  Header header;
  std::string child_frame_id;
  PoseWithCovariance pose;
  TwistWithCovariance twist;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.child_frame_id, m.pose, m.twist);
  }
  friend bool operator==(const Odometry&, const Odometry&) = default;
};

}  // namespace musher::msg
