#pragma once
// Whether the multicast group of a motion board on LCM can be reached. Nothing is sent.

#include <vector>

#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// Of each actuator that runs `musher-motion-manager FILE` on this host, where FILE has [board] kind
// = "lcm". A file that cannot be read is left out: `musher check` and the module itself report it.
std::vector<LcmFacts> ReadLcm(const MachineConfig& config);

}  // namespace musher::cli
