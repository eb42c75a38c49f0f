#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/JointState: how joints stand, or how they are to; one value for each name. An
// array that says nothing is empty.
struct JointState {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::JointState_";
  Header header;
  std::vector<std::string> name;
  std::vector<double> position;  // rad, or m
  std::vector<double> velocity;  // rad/s, or m/s
  std::vector<double> effort;    // N m, or N

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.name, m.position, m.velocity, m.effort);
  }
  friend bool operator==(const JointState&, const JointState&) = default;
};

}  // namespace musher::msg
