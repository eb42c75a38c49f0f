#pragma once
// Numbers of ports with a check; only for the nodes of this folder.

#include "musher/behavior/tree/port.hpp"

namespace musher::tree::nav2 {

// From 0, also without an end. A comparison with a number that is none is never true, and so a
// condition would hold for ever, or never.
inline double Checked(const InPort<double>& port) {
  const double value = port.Get();
  if (!(value >= 0)) throw PortError("port '" + port.name() + "' has to be a number from 0");
  return value;
}

}  // namespace musher::tree::nav2
