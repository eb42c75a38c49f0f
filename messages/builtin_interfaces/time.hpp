#pragma once
#include <chrono>

#include "musher/messages/cdr.hpp"

namespace musher::msg {

// builtin_interfaces/msg/Time: a point in time of a clock that the topic names.
struct Stamp {
  static constexpr std::string_view kTypeName = "builtin_interfaces::msg::dds_::Time_";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;  // 0 to 999999999, also before the clock's zero

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.sec, m.nanosec);
  }
  friend bool operator==(const Stamp&, const Stamp&) = default;
};

// `time` since the clock's zero, within what an int32 of seconds holds.
constexpr Stamp ToStamp(std::chrono::nanoseconds time) {
  const auto sec = std::chrono::floor<std::chrono::seconds>(time);
  return {static_cast<std::int32_t>(sec.count()), static_cast<std::uint32_t>((time - sec).count())};
}
constexpr std::chrono::nanoseconds FromStamp(const Stamp& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

}  // namespace musher::msg
