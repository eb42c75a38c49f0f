#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// protocol/msg/StateSwitchStatus: topic `state_switch_status`.
struct StateSwitchStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::StateSwitchStatus_";

  static constexpr std::int32_t kError = -2;
  static constexpr std::int32_t kUnknown = -1;
  static constexpr std::int32_t kActive = 0;
  static constexpr std::int32_t kProtected = 1;
  static constexpr std::int32_t kLowPower = 2;
  static constexpr std::int32_t kOta = 3;
  static constexpr std::int32_t kShutdown = 4;

  std::int32_t state = 0;
  std::int32_t code = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.state, m.code);
  }
  friend bool operator==(const StateSwitchStatus&, const StateSwitchStatus&) = default;
};

// protocol/msg/SelfCheckStatus: topic `self_check_status`, every second. -1 unknown, 0 all fine, 1
// checking, 2 a critical one failed (the start stops), 3 all fine and 4 with failures: starting, 5
// the start failed, 6 started with failures.
struct SelfCheckStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::SelfCheckStatus_";

  static constexpr std::int32_t kUnknown = -1;
  static constexpr std::int32_t kAllFine = 0;
  static constexpr std::int32_t kChecking = 1;
  static constexpr std::int32_t kCriticalFailed = 2;
  static constexpr std::int32_t kFineStarting = 3;
  static constexpr std::int32_t kFailedStarting = 4;
  static constexpr std::int32_t kSoftwareFailed = 5;
  static constexpr std::int32_t kFailedStarted = 6;

  std::int32_t code = 0;
  std::string description;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.code, m.description);
  }
  friend bool operator==(const SelfCheckStatus&, const SelfCheckStatus&) = default;
};

// protocol/msg/NodeError: topic `node_errors`, what a module reports.
struct NodeError {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::NodeError_";
  std::string name;
  std::int32_t code = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.code);
  }
  friend bool operator==(const NodeError&, const NodeError&) = default;
};

// protocol/msg/ManagerState: of an older manager.
struct ManagerState {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::ManagerState_";

  static constexpr std::int8_t kError = -1;
  static constexpr std::int8_t kOk = 0;
  static constexpr std::int8_t kNotReady = 1;
  static constexpr std::int8_t kLowPower = 2;
  static constexpr std::int8_t kProtected = 3;
  static constexpr std::int8_t kActive = 4;
  static constexpr std::int8_t kSuspend = 5;

  std::int8_t state = 0;
  std::string err_msg;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.state, m.err_msg);
  }
  friend bool operator==(const ManagerState&, const ManagerState&) = default;
};

// protocol/srv/MachineState: service `machine_state_switch_keep`.
struct MachineState {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MachineState_";

  static constexpr std::uint8_t kActive = 0;
  static constexpr std::uint8_t kProtect = 1;
  static constexpr std::uint8_t kLowPower = 2;
  static constexpr std::uint8_t kOta = 3;
  static constexpr std::uint8_t kShutdown = 4;
  static constexpr std::uint8_t kSelfCheck = 5;
  static constexpr std::uint8_t kDeActive = 6;
  static constexpr std::uint8_t kError = 7;

  struct Request {
    std::uint8_t state = 0;
    std::uint16_t ticks = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.state, m.ticks);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/DeviceInfo: service `query_divice_info` (sic). `enables` selects, in this order:
// sn, version, uid, nick_name, volume, mic_state, voice_control, wifi, bat_info, motor_temper,
// audio_state, device_model, stand, lowpower_control, charging.
struct DeviceInfo {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::DeviceInfo_";
  struct Request {
    std::vector<bool> enables;
    std::string uid;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.enables, m.uid);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::string info;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.info, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/UidSn: service `uid_sn`.
struct UidSn {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::UidSn_";
  using Request = Empty;
  struct Response {
    std::string uid;
    std::string sn;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.uid, m.sn, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
