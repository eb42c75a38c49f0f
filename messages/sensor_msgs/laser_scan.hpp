#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/LaserScan: distances around the sensor, one for each angle. -Inf is too near to
// be measured, +Inf is nothing within range (REP 117).
struct LaserScan {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::LaserScan_";
  Header header;
  float angle_min = 0;
  float angle_max = 0;
  float angle_increment = 0;
  float time_increment = 0;
  float scan_time = 0;
  float range_min = 0;
  float range_max = 0;
  std::vector<float> ranges;
  std::vector<float> intensities;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.angle_min, m.angle_max, m.angle_increment, m.time_increment,
                    m.scan_time, m.range_min, m.range_max, m.ranges, m.intensities);
  }
  friend bool operator==(const LaserScan&, const LaserScan&) = default;
};

}  // namespace musher::msg
