#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// protocol/msg/Heartbeats: topic `manager_heartbeats`, each module's heartbeat, every 500 ms.
struct Heartbeats {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::Heartbeats_";
  std::string name;
  std::int8_t state = 0;
  std::int64_t timestamp = 0;
  std::string params;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.state, m.timestamp, m.params);
  }
  friend bool operator==(const Heartbeats&, const Heartbeats&) = default;
};

}  // namespace musher::msg
