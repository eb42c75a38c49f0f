#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// musher_msgs/msg/ActuatorBeat: an actuator's heartbeat, on `<namespace>/musher/actuator_beat`.
// Field comments: messages/idl/musher_msgs.idl.
struct ActuatorBeat {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::ActuatorBeat_";

  static constexpr std::uint8_t kWorkWell = 0;
  static constexpr std::uint8_t kWorkStarved = 1;
  static constexpr std::uint8_t kWorkHung = 2;
  std::string name;
  std::uint64_t incarnation = 0;
  std::int64_t period_ns = 0;
  std::uint8_t work = 0;
  std::string during;
  std::int64_t silent_ns = 0;
  std::int64_t waited_ns = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.incarnation, m.period_ns, m.work, m.during, m.silent_ns, m.waited_ns);
  }
  friend bool operator==(const ActuatorBeat&, const ActuatorBeat&) = default;
};

// musher_msgs/msg/ControllerBeat: a controller's heartbeat with its epoch, latched on
// `<namespace>/musher/controller_beat`.
struct ControllerBeat {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::ControllerBeat_";
  std::string machine;
  std::uint64_t epoch = 0;
  std::uint64_t incarnation = 0;
  std::string host;
  std::int32_t pid = 0;
  std::int64_t period_ns = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.machine, m.epoch, m.incarnation, m.host, m.pid, m.period_ns);
  }
  friend bool operator==(const ControllerBeat&, const ControllerBeat&) = default;
};

// musher_msgs/msg/EmergencyStop: reliable and latched on `<namespace>/musher/emergency_stop`.
struct EmergencyStop {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::EmergencyStop_";
  std::uint64_t id = 0;
  bool engaged = false;
  std::string by;
  std::string reason;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.engaged, m.by, m.reason);
  }
  friend bool operator==(const EmergencyStop&, const EmergencyStop&) = default;
};

}  // namespace musher::msg
