#pragma once
// The time that decision code is given. Nothing in lifecycle/ reads a clock: a point in time is
// always an argument, so that a test or a simulation can hand in its own.

#include <chrono>
#include <cstdint>

namespace musher {

using Duration = std::chrono::nanoseconds;

// Steady time of one process. Points of different processes or hosts must not be compared.
using Time = std::chrono::steady_clock::time_point;

// No clock of a process goes so far; times within it, either way, can be added up.
inline constexpr std::int64_t kFarthestNs = std::int64_t{1} << 61;

constexpr Duration Milliseconds(std::int64_t ms) {
  return std::chrono::milliseconds(ms);
}
constexpr std::int64_t ToMilliseconds(Duration d) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(d).count();
}

constexpr double ToSeconds(Duration d) {
  return std::chrono::duration<double>(d).count();
}
// The part of it that is less than a nanosecond is dropped. At most 9e9 s either way.
constexpr Duration FromSeconds(double s) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}

}  // namespace musher
