#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// protocol/msg/BmsStatus: topic `bms_status`, the battery and its power board. Faults: true is one.
struct BmsStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::BmsStatus_";
  Header header;
  std::uint16_t batt_volt = 0;
  std::int16_t batt_curr = 0;
  std::uint8_t batt_soc = 0;
  std::int16_t batt_temp = 0;
  std::int16_t power_adapter_temp = 0;
  std::int16_t wireless_charging_temp = 0;
  std::uint8_t batt_st = 0;
  std::uint8_t bms_state_one = 0;
  std::uint8_t bms_state_two = 0;
  std::int8_t batt_health = 0;
  std::int16_t batt_loop_number = 0;
  bool power_normal = false;
  bool power_wired_charging = false;
  bool power_finished_charging = false;
  bool power_motor_shutdown = false;
  bool power_soft_shutdown = false;
  bool power_wp_place = false;
  bool power_wp_charging = false;
  bool power_expower_supply = false;
  bool charge_over_current = false;
  bool discharge_over_current = false;
  bool cell_over_voltage = false;
  bool cell_under_voltage = false;
  bool cell_volt_abnormal = false;
  bool mos_over_temp = false;
  bool discharge_short = false;
  bool fuse = false;
  bool discharge_over_tmp = false;
  bool discharge_under_tmp = false;
  bool charge_over_temp = false;
  bool charge_under_temp = false;
  bool charge_mos_state = false;
  bool discharge_mos_state = false;
  bool chg_mos_fault = false;
  bool dsg_mos_fault = false;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.batt_volt, m.batt_curr, m.batt_soc, m.batt_temp,
                    m.power_adapter_temp, m.wireless_charging_temp, m.batt_st, m.bms_state_one,
                    m.bms_state_two, m.batt_health, m.batt_loop_number, m.power_normal,
                    m.power_wired_charging, m.power_finished_charging, m.power_motor_shutdown,
                    m.power_soft_shutdown, m.power_wp_place, m.power_wp_charging,
                    m.power_expower_supply, m.charge_over_current, m.discharge_over_current,
                    m.cell_over_voltage, m.cell_under_voltage, m.cell_volt_abnormal,
                    m.mos_over_temp, m.discharge_short, m.fuse, m.discharge_over_tmp,
                    m.discharge_under_tmp, m.charge_over_temp, m.charge_under_temp,
                    m.charge_mos_state, m.discharge_mos_state, m.chg_mos_fault, m.dsg_mos_fault);
  }
  friend bool operator==(const BmsStatus&, const BmsStatus&) = default;
};

// protocol/msg/TouchStatus: topic `touch_status`.
struct TouchStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::TouchStatus_";

  static constexpr std::int32_t kSingle = 1;
  static constexpr std::int32_t kDouble = 3;
  static constexpr std::int32_t kHold = 7;
  static constexpr std::int32_t kCircle = 8;

  Header header;
  std::int32_t touch_state = 0;
  std::uint64_t timestamp = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.touch_state, m.timestamp);
  }
  friend bool operator==(const TouchStatus&, const TouchStatus&) = default;
};

// protocol/msg/UwbRaw: topic `uwb_raw`, where a tag is.
struct UwbRaw {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::UwbRaw_";
  Header header;
  float dist = 0;
  float angle = 0;
  float n_los = 0;
  float rssi_1 = 0;
  float rssi_2 = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.dist, m.angle, m.n_los, m.rssi_1, m.rssi_2);
  }
  friend bool operator==(const UwbRaw&, const UwbRaw&) = default;
};

// protocol/srv/LedExecute: service `led_execute`: a client requests a light.
struct LedExecute {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::LedExecute_";

  static constexpr std::uint8_t kHead = 1;
  static constexpr std::uint8_t kTail = 2;
  static constexpr std::uint8_t kMini = 3;
  static constexpr std::uint8_t kPredefined = 1;
  static constexpr std::uint8_t kUserColor = 2;
  static constexpr std::uint8_t kRgbOn = 0x01;
  static constexpr std::uint8_t kBlink = 0x02;
  static constexpr std::uint8_t kBlinkFast = 0x03;
  static constexpr std::uint8_t kBreath = 0x04;
  static constexpr std::uint8_t kBreathFast = 0x05;
  static constexpr std::uint8_t kOneByOne = 0x06;
  static constexpr std::uint8_t kOneByOneFast = 0x07;
  static constexpr std::uint8_t kBackAndForth = 0x08;
  static constexpr std::uint8_t kTrailingRace = 0x09;
  static constexpr std::uint8_t kCircularBreath = 0x30;
  static constexpr std::uint8_t kCircularRing = 0x31;
  static constexpr std::uint8_t kMiniOff = 0x32;
  static constexpr std::uint8_t kColorOneByOne = 0x36;
  static constexpr std::uint8_t kRgbOff = 0xA0;
  static constexpr std::uint8_t kRedOn = 0xA1;
  static constexpr std::uint8_t kRedBlinkFast = 0xA3;
  static constexpr std::uint8_t kYellowOneByOneFast = 0xB5;

  struct Request {
    bool occupation = false;
    std::string client;
    std::uint8_t target = 0;
    std::uint8_t mode = 0;
    std::uint8_t effect = 0;
    std::uint8_t r_value = 0;
    std::uint8_t g_value = 0;
    std::uint8_t b_value = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.occupation, m.client, m.target, m.mode, m.effect, m.r_value, m.g_value,
                      m.b_value);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/BmsCmd: service `bms_cmd`.
struct BmsCmd {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::BmsCmd_";

  static constexpr std::uint8_t kMotorsUp = 1;
  static constexpr std::uint8_t kMotorsDown = 2;
  static constexpr std::uint8_t kWirelessChargingOn = 3;
  static constexpr std::uint8_t kWirelessChargingOff = 4;

  struct Request {
    std::uint8_t electric_machine_command = 0;
    std::uint8_t wireless_charging_command = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.electric_machine_command, m.wireless_charging_command);
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

// protocol/srv/BmsInfo: service `bms_info`, the last battery message.
struct BmsInfo {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::BmsInfo_";
  using Request = Empty;
  struct Response {
    BmsStatus msg;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.msg, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/GetUWBMacSessionID: service `get_uwb_mac_session_id`.
struct GetUWBMacSessionID {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::GetUWBMacSessionID_";
  using Request = Empty;
  struct Response {
    std::uint32_t session_id = 0;
    std::uint16_t master = 0;
    std::uint16_t slave1 = 0;
    std::uint16_t slave2 = 0;
    std::uint16_t slave3 = 0;
    std::uint16_t slave4 = 0;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.session_id, m.master, m.slave1, m.slave2, m.slave3, m.slave4, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
