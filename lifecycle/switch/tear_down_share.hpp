#pragma once
// How the actuators of a TearDown share its time. Where their times do not fit into what is left,
// those that are torn down one after another each get a part in proportion to their time: an
// actuator that hangs does not use the time of those that are torn down after it. Where the times
// fit, each has all of its own.

#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/switch.hpp"

namespace musher {

// For each actuator with a leg, the longest time that it and those that wait for it, one after
// another, may take.
PerActuator<Duration> ChainTimes(const MachineConfig& config, const std::vector<Leg>& legs);

// The part of `left` for an actuator that may take `time`, in a chain that may take `chain`.
Duration ShareOf(Duration left, Duration time, Duration chain);

}  // namespace musher
