#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// std_msgs/msg/Bool
struct Bool {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::Bool_";
  bool data = false;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const Bool&, const Bool&) = default;
};

// std_msgs/msg/UInt8
struct UInt8 {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::UInt8_";
  std::uint8_t data = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const UInt8&, const UInt8&) = default;
};

// std_msgs/msg/UInt16
struct UInt16 {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::UInt16_";
  std::uint16_t data = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const UInt16&, const UInt16&) = default;
};

// std_msgs/msg/Int32
struct Int32 {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::Int32_";
  std::int32_t data = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const Int32&, const Int32&) = default;
};

// std_msgs/msg/Float32
struct Float32 {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::Float32_";
  float data = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
  friend bool operator==(const Float32&, const Float32&) = default;
};

// std_msgs/msg/ColorRGBA: each from 0 to 1.
struct ColorRGBA {
  static constexpr std::string_view kTypeName = "std_msgs::msg::dds_::ColorRGBA_";
  float r = 0;
  float g = 0;
  float b = 0;
  float a = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.r, m.g, m.b, m.a);
  }
  friend bool operator==(const ColorRGBA&, const ColorRGBA&) = default;
};

}  // namespace musher::msg
