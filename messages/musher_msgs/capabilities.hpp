#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// musher_msgs/msg/Capability: a function of the robot, and whether it may run now. Field comments:
// messages/idl/musher_msgs.idl.
struct Capability {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::Capability_";
  std::string name;
  std::string description;
  bool allowed = false;
  std::int32_t code = 0;
  std::string reason;
  std::vector<std::string> actuators;
  std::vector<std::string> states;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.description, m.allowed, m.code, m.reason, m.actuators, m.states);
  }
  friend bool operator==(const Capability&, const Capability&) = default;
};

// musher_msgs/msg/Capabilities: what the robot can do now, latched on
// `<namespace>/musher/capabilities`.
struct Capabilities {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::Capabilities_";
  std::vector<Capability> capabilities;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.capabilities);
  }
  friend bool operator==(const Capabilities&, const Capabilities&) = default;
};

// musher_msgs/srv/GetCapabilities: service `musher/get_capabilities`.
struct GetCapabilities {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::GetCapabilities_";
  using Request = Empty;
  using Response = Capabilities;
};

}  // namespace musher::msg
