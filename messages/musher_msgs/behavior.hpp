#pragma once
// What an application that is a state machine reports about it. Field comments:
// messages/idl/musher_msgs_behavior.idl.

#include "musher/messages/cdr.hpp"

namespace musher::msg {

// musher_msgs/msg/BehaviorChange
struct BehaviorChange {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::BehaviorChange_";
  double time_s = 0;
  std::uint64_t tick = 0;
  std::string from;
  std::string to;
  std::string cause;
  std::string command;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.time_s, m.tick, m.from, m.to, m.cause, m.command);
  }
  friend bool operator==(const BehaviorChange&, const BehaviorChange&) = default;
};

// musher_msgs/srv/GetBehavior: service `<actuator>/get_behavior`.
struct GetBehavior {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::GetBehavior_";
  struct Request {
    std::string format;
    std::uint32_t history = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.format, m.history);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::string error;
    bool running = false;
    bool ticking = false;
    std::string current_state;
    std::string operating_mode;
    std::uint64_t iter_count = 0;
    bool safety_triggered = false;
    std::string unsafe;
    double time_s = 0;
    double time_in_state_s = 0;
    std::string last_fault;
    std::string graph;
    std::vector<BehaviorChange> history;
    bool held_by_stop = false;
    std::vector<std::string> commands;

    static constexpr std::size_t kAppended = 2;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.error, m.running, m.ticking, m.current_state, m.operating_mode,
                      m.iter_count, m.safety_triggered, m.unsafe, m.time_s, m.time_in_state_s,
                      m.last_fault, m.graph, m.history, m.held_by_stop, m.commands);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/srv/SendCommand: service `<actuator>/send_command`.
struct SendCommand {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::SendCommand_";
  struct Request {
    std::string command;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.command);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;
    std::string message;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success, m.message);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
