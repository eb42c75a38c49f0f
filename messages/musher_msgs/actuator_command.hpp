#pragma once
#include "musher/messages/musher_msgs/actuator_status.hpp"

namespace musher::msg {

// musher_msgs/srv/ActuatorCommand: service `<namespace>/<actuator>/musher_command`, how a
// controller drives an actuator. Field comments: messages/idl/musher_msgs.idl.
struct ActuatorCommand {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::ActuatorCommand_";

  static constexpr std::uint8_t kKindSwitch = 1;
  static constexpr std::uint8_t kKindAsk = 2;
  struct Request {
    std::uint8_t kind = 0;
    std::uint64_t epoch = 0;
    std::uint64_t number = 0;
    std::string target;
    std::int64_t budget_ns = 0;
    std::int64_t status_stamp_ns = 0;
    std::int64_t since_status_ns = 0;
    std::uint64_t incarnation = 0;
    bool stop = false;
    bool apart = false;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.kind, m.epoch, m.number, m.target, m.budget_ns, m.status_stamp_ns,
                      m.since_status_ns, m.incarnation, m.stop, m.apart);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };

  static constexpr std::uint8_t kVerdictDone = 0;
  static constexpr std::uint8_t kVerdictRefused = 1;
  static constexpr std::uint8_t kVerdictFailed = 2;
  struct Response {
    std::uint8_t verdict = 0;
    std::int32_t code = 0;
    std::string message;
    ActuatorStatus status;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.verdict, m.code, m.message, m.status);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
