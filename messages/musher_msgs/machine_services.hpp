#pragma once
// The services of a controller, all under `<namespace>/musher/`. Field comments:
// messages/idl/musher_msgs.idl.

#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::msg {

// musher_msgs/msg/ActuatorOutcome: what a switch did to one actuator.
struct ActuatorOutcome {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::ActuatorOutcome_";
  std::string name;
  std::string outcome;
  std::int32_t code = 0;
  std::string message;
  double duration_ms = 0;
  std::string state;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.outcome, m.code, m.message, m.duration_ms, m.state);
  }
  friend bool operator==(const ActuatorOutcome&, const ActuatorOutcome&) = default;
};

// musher_msgs/srv/SetState: service `musher/set_state`. Answers when the switch has ended.
struct SetState {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::SetState_";
  struct Request {
    std::string target;
    std::string actuator;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.target, m.actuator);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::uint64_t switch_number = 0;
    std::string target;
    std::string actuator;
    std::string outcome;
    std::int32_t code = 0;
    std::string reason;
    std::string state;
    std::vector<std::string> degraded;
    std::vector<ActuatorOutcome> actuators;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.switch_number, m.target, m.actuator, m.outcome, m.code, m.reason, m.state,
                      m.degraded, m.actuators);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/srv/RestartActuator: service `musher/restart_actuator`.
struct RestartActuator {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::RestartActuator_";
  struct Request {
    std::string actuator;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.actuator);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::int32_t code = 0;
    std::string reason;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.code, m.reason);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/srv/ReleaseEmergencyStop: service `musher/release_emergency_stop`.
struct ReleaseEmergencyStop {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::ReleaseEmergencyStop_";
  struct Request {
    std::string by;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.by);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::int32_t code = 0;
    std::string reason;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.code, m.reason);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/srv/GetStatus: service `musher/get_status`.
struct GetStatus {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::GetStatus_";
  using Request = Empty;
  struct Response {
    MachineStatus status;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.status);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/msg/PlanStep: what a switch would do to one actuator.
struct PlanStep {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::PlanStep_";
  std::string name;
  std::int32_t wave = 0;
  std::string from;
  std::string to;
  std::int64_t deadline_ms = 0;
  std::string note;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.wave, m.from, m.to, m.deadline_ms, m.note);
  }
  friend bool operator==(const PlanStep&, const PlanStep&) = default;
};

// musher_msgs/srv/GetPlan: service `musher/get_plan`. Changes nothing.
struct GetPlan {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::GetPlan_";
  using Request = SetState::Request;
  struct Response {
    std::string target;
    std::string actuator;
    bool allowed = false;
    std::int32_t code = 0;
    std::string reason;
    std::string direction;
    std::string state;
    std::vector<PlanStep> steps;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.target, m.actuator, m.allowed, m.code, m.reason, m.direction, m.state,
                      m.steps);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/srv/GetSwitch: service `musher/get_switch`. The outcome of a switch.
struct GetSwitch {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::GetSwitch_";
  static constexpr const char* kUnderWay = "under way";
  static constexpr const char* kInterrupted = "interrupted";
  struct Request {
    std::uint64_t epoch = 0;
    std::uint64_t switch_number = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.epoch, m.switch_number);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool found = false;
    std::uint64_t epoch = 0;
    std::uint64_t switch_number = 0;
    std::string target;
    std::string actuator;
    std::string outcome;
    std::int32_t code = 0;
    std::string reason;
    std::string state;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.found, m.epoch, m.switch_number, m.target, m.actuator, m.outcome, m.code,
                      m.reason, m.state);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// musher_msgs/msg/HistoryEntry: a line of the journal.
struct HistoryEntry {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::HistoryEntry_";
  std::uint64_t id = 0;
  std::int64_t wall_ns = 0;
  std::uint64_t epoch = 0;
  std::uint64_t switch_number = 0;
  std::string kind;
  std::string actuator;
  std::int32_t code = 0;
  std::string message;
  std::uint64_t cause = 0;
  std::string state{};
  std::string data{};

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.wall_ns, m.epoch, m.switch_number, m.kind, m.actuator, m.code,
                    m.message, m.cause, m.state, m.data);
  }
  friend bool operator==(const HistoryEntry&, const HistoryEntry&) = default;
};

// musher_msgs/srv/GetHistory: service `musher/get_history`.
struct GetHistory {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::GetHistory_";
  struct Request {
    std::int64_t since_wall_ns = 0;
    std::uint32_t limit = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.since_wall_ns, m.limit);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::string error;
    std::vector<HistoryEntry> entries;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.error, m.entries);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
