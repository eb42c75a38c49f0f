#pragma once
// What a state config names outside of itself, on this computer: programs, folders, and the files
// of musher-exec and of Musher's own modules. For `musher check`, which may run on another computer
// than the robot: what is missing here is a warning.

#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/diagnostic.hpp"

namespace musher::cli {

// Runs `musher-… --check` for the programs of Musher's own; nothing else is run. By position.
std::vector<Diagnostic> CheckSurroundings(const MachineConfig& config);

}  // namespace musher::cli
