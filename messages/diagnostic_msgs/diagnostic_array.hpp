#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// diagnostic_msgs/msg/KeyValue
struct KeyValue {
  static constexpr std::string_view kTypeName = "diagnostic_msgs::msg::dds_::KeyValue_";
  std::string key;
  std::string value;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.key, m.value);
  }
  friend bool operator==(const KeyValue&, const KeyValue&) = default;
};

// diagnostic_msgs/msg/DiagnosticStatus
struct DiagnosticStatus {
  static constexpr std::string_view kTypeName = "diagnostic_msgs::msg::dds_::DiagnosticStatus_";
  static constexpr std::uint8_t kOk = 0;
  static constexpr std::uint8_t kWarn = 1;
  static constexpr std::uint8_t kError = 2;
  static constexpr std::uint8_t kStale = 3;

  std::uint8_t level = kOk;
  std::string name;
  std::string message;
  std::string hardware_id;
  std::vector<KeyValue> values;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.level, m.name, m.message, m.hardware_id, m.values);
  }
  friend bool operator==(const DiagnosticStatus&, const DiagnosticStatus&) = default;
};

// diagnostic_msgs/msg/DiagnosticArray: topic `/diagnostics`.
struct DiagnosticArray {
  static constexpr std::string_view kTypeName = "diagnostic_msgs::msg::dds_::DiagnosticArray_";
  Header header;
  std::vector<DiagnosticStatus> status;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.status);
  }
  friend bool operator==(const DiagnosticArray&, const DiagnosticArray&) = default;
};

}  // namespace musher::msg
