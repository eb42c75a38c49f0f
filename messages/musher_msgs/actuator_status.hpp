#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// musher_msgs/msg/ActuatorStatus: what an actuator latches about itself. Published on
// `<namespace>/musher/actuator_status` (reliable, transient local, keep last 1 per writer) at every
// change, and part of every reply to a command. Field comments: messages/idl/musher_msgs.idl.
struct ActuatorStatus {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::ActuatorStatus_";
  std::string name;
  std::string state;
  std::string target;
  std::uint64_t busy_number = 0;
  std::uint64_t epoch = 0;
  std::uint64_t number = 0;
  std::uint64_t outcome_number = 0;
  std::int32_t outcome_code = 0;
  std::string outcome_message;
  std::uint64_t incarnation = 0;
  std::int32_t pid = 0;
  std::string host;
  std::string config_hash;
  bool apart = false;
  std::uint64_t emergency_stop = 0;
  std::int64_t stamp_ns = 0;
  bool held_by_stop = false;
  std::int32_t degraded_code = 0;
  std::string degraded_reason;
  std::string emergency_stop_by;
  std::string emergency_stop_reason;

  static constexpr std::size_t kAppended = 5;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.state, m.target, m.busy_number, m.epoch, m.number, m.outcome_number,
                    m.outcome_code, m.outcome_message, m.incarnation, m.pid, m.host, m.config_hash,
                    m.apart, m.emergency_stop, m.stamp_ns, m.held_by_stop, m.degraded_code,
                    m.degraded_reason, m.emergency_stop_by, m.emergency_stop_reason);
  }
  friend bool operator==(const ActuatorStatus&, const ActuatorStatus&) = default;
};

}  // namespace musher::msg
