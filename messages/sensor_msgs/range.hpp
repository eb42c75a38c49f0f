#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/Range: one distance for a whole cone. -Inf is too near to be measured, +Inf is
// nothing within range (REP 117). The last field is younger than CyberDog's ROS 2.
struct Range {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::Range_";

  static constexpr std::uint8_t kUltrasound = 0;
  static constexpr std::uint8_t kInfrared = 1;

  Header header;
  std::uint8_t radiation_type = kUltrasound;
  float field_of_view = 0;
  float min_range = 0;
  float max_range = 0;
  float range = 0;
  float variance = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.radiation_type, m.field_of_view, m.min_range, m.max_range, m.range,
                    m.variance);
  }
  friend bool operator==(const Range&, const Range&) = default;
};

}  // namespace musher::msg
