#pragma once
#include "musher/messages/cdr.hpp"
#include "musher/messages/musher_msgs/policy_info.hpp"

namespace musher::msg {

// musher_msgs/msg/ActuatorInfo: one actuator as the controller sees it.
struct ActuatorInfo {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::ActuatorInfo_";
  std::string name;
  std::string state;
  std::string target;
  std::string presence;
  std::int32_t pid = 0;
  std::string host;
  std::int32_t stage = 0;
  bool critical = false;
  bool held = false;
  bool degraded = false;
  std::int32_t code = 0;
  std::string message;
  std::string health;
  std::int32_t restarts = 0;
  bool restarting = false;
  std::string protocol;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.state, m.target, m.presence, m.pid, m.host, m.stage, m.critical,
                    m.held, m.degraded, m.code, m.message, m.health, m.restarts, m.restarting,
                    m.protocol);
  }
  friend bool operator==(const ActuatorInfo&, const ActuatorInfo&) = default;
};

// musher_msgs/msg/MachineStatus: the machine as a whole, latched on
// `<namespace>/musher/machine_status`. Field comments: messages/idl/musher_msgs.idl.
struct MachineStatus {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::MachineStatus_";
  std::string machine;
  std::string name_space;
  std::string phase;
  std::string state;
  std::string target;
  std::uint64_t epoch = 0;
  std::uint64_t switch_number = 0;
  std::int32_t pid = 0;
  std::string host;
  std::string config_file;
  std::string config_hash;
  bool emergency_stop = false;
  std::string emergency_stop_by;
  std::string emergency_stop_reason;
  std::vector<std::string> degraded;
  std::vector<ActuatorInfo> actuators;
  PolicyInfo policy;
  std::vector<std::string> not_on_disk;
  std::vector<std::string> held_by_stop;

  static constexpr std::size_t kAppended = 1;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.machine, m.name_space, m.phase, m.state, m.target, m.epoch, m.switch_number,
                    m.pid, m.host, m.config_file, m.config_hash, m.emergency_stop,
                    m.emergency_stop_by, m.emergency_stop_reason, m.degraded, m.actuators, m.policy,
                    m.not_on_disk, m.held_by_stop);
  }
  friend bool operator==(const MachineStatus&, const MachineStatus&) = default;
};

// musher_msgs/msg/MachineInfo: the leading controller of a machine, on the global topic
// `musher/machines` (latched), so that the command line can list the namespaces after a wrong one.
struct MachineInfo {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::MachineInfo_";
  std::string machine;
  std::string name_space;
  std::string host;
  std::int32_t pid = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.machine, m.name_space, m.host, m.pid);
  }
  friend bool operator==(const MachineInfo&, const MachineInfo&) = default;
};

}  // namespace musher::msg
