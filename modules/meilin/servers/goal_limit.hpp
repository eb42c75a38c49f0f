#pragma once
// The limits of goals. Pure.

#include <algorithm>

#include "musher/base/time.hpp"

namespace musher::meilin::servers {

// The limit of a goal: `limit_s`, at most an hour; `otherwise` if it is not above 0.
inline Duration LimitOf(double limit_s, Duration otherwise) {
  if (!(limit_s > 0)) return otherwise;
  constexpr double kMostS = 3600;
  return FromSeconds(std::min(limit_s, kMostS));
}

}  // namespace musher::meilin::servers
