#pragma once
// Durations as seconds. Pure.

#include <algorithm>
#include <chrono>

#include "musher/base/time.hpp"

namespace musher::meilin::servers {

inline double Seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

// The limit of a goal: `limit_s`, at most an hour; `otherwise` if it is not above 0.
inline Duration LimitOf(double limit_s, Duration otherwise) {
  if (!(limit_s > 0)) return otherwise;
  constexpr double kMostS = 3600;
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::min(limit_s, kMostS)));
}

}  // namespace musher::meilin::servers
