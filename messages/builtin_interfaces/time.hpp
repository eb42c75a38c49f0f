#pragma once
#include <chrono>

#include "musher/messages/cdr.hpp"

namespace musher::msg {

// builtin_interfaces/msg/Time: seconds and nanoseconds since the clock's zero.
struct Stamp {
  static constexpr std::string_view kTypeName = "builtin_interfaces::msg::dds_::Time_";
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.sec, m.nanosec);
  }
  friend bool operator==(const Stamp&, const Stamp&) = default;
};

inline Stamp ToStamp(std::chrono::nanoseconds time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return {static_cast<std::int32_t>(seconds.count()),
          static_cast<std::uint32_t>((time - seconds).count())};
}

inline std::chrono::nanoseconds FromStamp(const Stamp& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

}  // namespace musher::msg
