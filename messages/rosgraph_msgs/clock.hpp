#pragma once
#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher::msg {

// rosgraph_msgs/msg/Clock: topic `/clock`, the time of a simulation or a replay.
struct Clock {
  static constexpr std::string_view kTypeName = "rosgraph_msgs::msg::dds_::Clock_";
  Stamp clock;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.clock);
  }
  friend bool operator==(const Clock&, const Clock&) = default;
};

}  // namespace musher::msg
