#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// protocol/msg/Bms: the battery as the older board described it; today it is BmsStatus.
struct Bms {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::Bms_";
  std::uint16_t batt_volt = 0;
  std::int16_t batt_curr = 0;
  std::uint8_t batt_soc = 0;
  std::int16_t batt_temp = 0;
  std::uint8_t batt_st = 0;
  std::uint8_t key_val = 0;
  std::uint8_t disable_charge = 0;
  std::uint8_t power_supply = 0;
  std::uint8_t buzze = 0;
  std::uint8_t status = 0;
  std::int8_t batt_health = 0;
  std::int16_t batt_loop_number = 0;
  std::int8_t powerboard_status = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.batt_volt, m.batt_curr, m.batt_soc, m.batt_temp, m.batt_st, m.key_val,
                    m.disable_charge, m.power_supply, m.buzze, m.status, m.batt_health,
                    m.batt_loop_number, m.powerboard_status);
  }
  friend bool operator==(const Bms&, const Bms&) = default;
};

// protocol/msg/ConnectorStatus: how the robot is connected to its app.
struct ConnectorStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::ConnectorStatus_";
  bool is_connected = false;
  bool is_internet = false;
  std::string ssid;
  std::string robot_ip;
  std::string provider_ip;
  std::uint8_t strength = 0;
  std::int32_t code = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.is_connected, m.is_internet, m.ssid, m.robot_ip, m.provider_ip, m.strength,
                    m.code);
  }
  friend bool operator==(const ConnectorStatus&, const ConnectorStatus&) = default;
};

// protocol/msg/AlgoTaskStatus: what the algorithm manager does.
struct AlgoTaskStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::AlgoTaskStatus_";
  std::uint8_t task_status = 0;
  std::int32_t task_sub_status = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.task_status, m.task_sub_status);
  }
  friend bool operator==(const AlgoTaskStatus&, const AlgoTaskStatus&) = default;
};

// protocol/srv/ManagerInit: service `manager_check_<name>` of the older start.
struct ManagerInit {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::ManagerInit_";
  using Request = Empty;
  struct Response {
    std::int32_t res_code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.res_code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/TaskProcessor: whether a task may run.
struct TaskProcessor {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::TaskProcessor_";
  struct Request {
    std::uint8_t processor = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.processor);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool purview = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.purview, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/Trigger: that of std_srvs with data and a code.
struct ProtocolTrigger {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::Trigger_";
  struct Request {
    std::string data;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.data);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;
    std::string message;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success, m.message, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
