#pragma once
#include "musher/messages/sensor_msgs/range.hpp"

namespace musher::msg {

// protocol/msg/UltrasonicPayload. Topic `ultrasonic_payload` carries the Range itself.
struct UltrasonicPayload {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::UltrasonicPayload_";
  Range ultrasonic_info;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.ultrasonic_info);
  }
  friend bool operator==(const UltrasonicPayload&, const UltrasonicPayload&) = default;
};

// protocol/msg/SingleTofPayload: one time-of-flight sensor of 8 by 8 zones.
struct SingleTofPayload {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::SingleTofPayload_";

  static constexpr std::uint8_t kLeftHead = 0;
  static constexpr std::uint8_t kRightHead = 1;
  static constexpr std::uint8_t kLeftRear = 2;
  static constexpr std::uint8_t kRightRear = 3;
  static constexpr std::uint8_t kHead = 4;
  static constexpr std::uint8_t kRear = 5;
  static constexpr std::size_t kZones = 64;
  static constexpr float kScale = 0.001F;  // metres of one step of the sensor

  Header header;
  bool data_available = false;
  std::uint8_t tof_position = 0;
  std::vector<float> data;
  std::vector<float> intensity;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.data_available, m.tof_position, m.data, m.intensity);
  }
  friend bool operator==(const SingleTofPayload&, const SingleTofPayload&) = default;
};

// protocol/msg/HeadTofPayload: topic `head_tof_payload`.
struct HeadTofPayload {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::HeadTofPayload_";
  SingleTofPayload left_head;
  SingleTofPayload right_head;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.left_head, m.right_head);
  }
  friend bool operator==(const HeadTofPayload&, const HeadTofPayload&) = default;
};

// protocol/msg/RearTofPayload: topic `rear_tof_payload`.
struct RearTofPayload {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::RearTofPayload_";
  SingleTofPayload left_rear;
  SingleTofPayload right_rear;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.left_rear, m.right_rear);
  }
  friend bool operator==(const RearTofPayload&, const RearTofPayload&) = default;
};

// protocol/msg/GpsPayload: topic `gps_payload`.
struct GpsPayload {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::GpsPayload_";
  std::uint32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::uint32_t itow = 0;  // ms of the GPS week
  std::uint8_t fix_type = 0;
  std::uint8_t num_sv = 0;
  double lon = 0;
  double lat = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.sec, m.nanosec, m.itow, m.fix_type, m.num_sv, m.lon, m.lat);
  }
  friend bool operator==(const GpsPayload&, const GpsPayload&) = default;
};

// protocol/srv/SensorOperation: service `sensor_operation`.
struct SensorOperation {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::SensorOperation_";

  static constexpr std::uint16_t kAll = 0;
  static constexpr std::uint16_t kLidar = 1;
  static constexpr std::uint16_t kUltrasonic = 2;
  static constexpr std::uint16_t kTof = 3;
  static constexpr std::uint16_t kGps = 4;
  static constexpr std::uint8_t kOpen = 1;
  static constexpr std::uint8_t kStart = 2;
  static constexpr std::uint8_t kStop = 3;
  static constexpr std::uint8_t kClose = 4;

  struct Request {
    std::uint16_t sensor_id = 0;
    std::uint8_t operation = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.sensor_id, m.operation);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
