#pragma once
// Reads the facts of this computer for `musher doctor`.

#include "musher/cli/console/options.hpp"
#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// Blocks for some seconds at most, whatever disk, network or programs do. To be used before this
// process has threads.
DoctorFacts ReadFacts(std::optional<MachineConfig> config, const GlobalOptions& global);

}  // namespace musher::cli
