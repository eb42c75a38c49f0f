#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/Range: one distance for a whole cone. -Inf is too near to be measured, +Inf is
// nothing within range (REP 117). The layout depends on the ROS 2 distribution: `variance` exists
// since Iron. A Range without it, as Galactic (CyberDog's) and Humble publish it, is read as
// variance 0.
struct Range {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::Range_";

  static constexpr std::size_t kAppended = 1;

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

// The same message in the layout of ROS 2 Galactic and Humble, to be published for their nodes.
struct RangeBeforeIron {
  static constexpr std::string_view kTypeName = Range::kTypeName;

  Header header;
  std::uint8_t radiation_type = Range::kUltrasound;
  float field_of_view = 0;
  float min_range = 0;
  float max_range = 0;
  float range = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.radiation_type, m.field_of_view, m.min_range, m.max_range, m.range);
  }
  friend bool operator==(const RangeBeforeIron&, const RangeBeforeIron&) = default;
};

inline RangeBeforeIron BeforeIron(const Range& range) {
  return {range.header,    range.radiation_type, range.field_of_view,
          range.min_range, range.max_range,      range.range};
}

}  // namespace musher::msg
