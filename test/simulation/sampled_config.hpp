#pragma once
// Robots sampled from a seed: from one actuator to 32, some started by hand, in one stage or two,
// bound to each other or not, with every policy.

#include <cstdint>

#include "musher/lifecycle/config/config.hpp"

namespace musher::testing {

MachineConfig SampleConfig(std::uint64_t seed);

// The same robot with two or three hosts, whose systemds run some of the actuators as units: in
// half of the robots all that a controller starts.
MachineConfig SampleConfigWithUnits(std::uint64_t seed);

// The same robot with a standby on another host. The first host has actuators, too: they are units
// of it, or started by hand.
MachineConfig SampleConfigWithStandby(std::uint64_t seed);

}  // namespace musher::testing
