#pragma once
#include "musher/messages/geometry_msgs/geometry.hpp"

namespace musher::msg {

// sensor_msgs/msg/Imu: a covariance whose first value is -1 says that there is no such reading.
struct Imu {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::Imu_";
  Header header;
  Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  Vector3 angular_velocity;
  std::array<double, 9> angular_velocity_covariance{};
  Vector3 linear_acceleration;
  std::array<double, 9> linear_acceleration_covariance{};

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.orientation, m.orientation_covariance, m.angular_velocity,
                    m.angular_velocity_covariance, m.linear_acceleration,
                    m.linear_acceleration_covariance);
  }
  friend bool operator==(const Imu&, const Imu&) = default;
};

}  // namespace musher::msg
