#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// bond/msg/Status: topic `bond`.
struct BondStatus {
  static constexpr std::string_view kTypeName = "bond::msg::dds_::Status_";
  Header header;
  std::string id;
  std::string instance_id;
  bool active = false;
  float heartbeat_timeout = 0;  // s
  float heartbeat_period = 0;   // s

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.id, m.instance_id, m.active, m.heartbeat_timeout,
                    m.heartbeat_period);
  }
  friend bool operator==(const BondStatus&, const BondStatus&) = default;
};

}  // namespace musher::msg
