#pragma once
#include "musher/messages/geometry_msgs/geometry.hpp"

namespace musher::msg {

// musher_msgs/msg/BodyState: topic `world/body_state`, what the board of a body reports.
struct BodyState {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::BodyState_";
  Header header;
  std::int8_t mode = 0;
  std::int8_t gait_id = 0;
  std::int8_t contact = 0;
  std::int8_t order_process_bar = 0;
  std::int8_t switch_status = 0;
  std::int8_t ori_error = 0;
  std::int16_t footpos_error = 0;
  std::array<std::int32_t, 12> motor_error{};
  std::array<float, 12> motor_temperature{};
  std::int8_t life_count = 0;
  Pose pose;
  Twist twist;
  Vector3 linear_acceleration;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.mode, m.gait_id, m.contact, m.order_process_bar, m.switch_status,
                    m.ori_error, m.footpos_error, m.motor_error, m.motor_temperature, m.life_count,
                    m.pose, m.twist, m.linear_acceleration);
  }
  friend bool operator==(const BodyState&, const BodyState&) = default;
};

// musher_msgs/msg/LedState: topic `world/led`, latched: what a light shows.
struct LedState {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::LedState_";
  std::uint8_t target = 0;
  std::uint8_t mode = 0;
  std::uint8_t effect = 0;
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  std::string client;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.target, m.mode, m.effect, m.r, m.g, m.b, m.client);
  }
  friend bool operator==(const LedState&, const LedState&) = default;
};

}  // namespace musher::msg
