#pragma once
// Numbers of ports with a check, and the result of a condition; only for the nodes of this folder.

#include "musher/base/time.hpp"
#include "musher/behavior/tree/port.hpp"
#include "musher/behavior/tree/status.hpp"

namespace musher::tree::nav2 {

inline Status StatusOf(bool holds) {
  return holds ? Status::kSuccess : Status::kFailure;
}

// From 0, also without an end. A comparison with a number that is none is never true, and so a
// condition would hold for ever, or never.
inline double Checked(const InPort<double>& port) {
  const double value = port.Get();
  if (!(value >= 0)) throw PortError("port '" + port.name() + "' has to be a number from 0");
  return value;
}

// The time limit that a port has in seconds.
inline Duration LimitOf(const InPort<double>& seconds) {
  const double limit_s = seconds.Get();
  if (!(limit_s >= 0 && limit_s < 1e6)) {
    throw PortError("port '" + seconds.name() + "' has to be from 0 to 1e6 s");
  }
  return FromSeconds(limit_s);
}

}  // namespace musher::tree::nav2
