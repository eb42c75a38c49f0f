#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// musher_msgs/msg/PolicyInfo: what the machine's own rules are about, part of MachineStatus.
struct PolicyInfo {
  static constexpr std::string_view kTypeName = "musher_msgs::msg::dds_::PolicyInfo_";
  bool active = false;
  std::int32_t battery = -1;
  bool charging = false;
  bool battery_silent = false;
  std::string ceiling;
  std::string ceiling_reason;
  std::string kept;
  std::int64_t keep_s = 0;
  bool low_power_switch = false;
  std::string power;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.active, m.battery, m.charging, m.battery_silent, m.ceiling, m.ceiling_reason,
                    m.kept, m.keep_s, m.low_power_switch, m.power);
  }
  friend bool operator==(const PolicyInfo&, const PolicyInfo&) = default;
};

}  // namespace musher::msg
