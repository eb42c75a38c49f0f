#pragma once
// ROS 2's stamps and C++'s times. Any thread.

#include <chrono>
#include <cstdint>

#include "musher/messages/builtin_interfaces/time.hpp"

namespace musher::msg {

// `time` since the clock's zero, within what an int32 of seconds holds.
constexpr Stamp ToStamp(std::chrono::nanoseconds time) {
  const auto sec = std::chrono::floor<std::chrono::seconds>(time);
  return {static_cast<std::int32_t>(sec.count()), static_cast<std::uint32_t>((time - sec).count())};
}
constexpr std::chrono::nanoseconds FromStamp(const Stamp& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

}  // namespace musher::msg
