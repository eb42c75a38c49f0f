#pragma once
// What a state config names on this computer: programs, folders, and the files that musher-exec and
// Musher's own modules read. For `musher check`, which may run on another computer than the robot:
// what is missing here is a warning.

#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/time.hpp"

namespace musher::cli {

// Of a faulty config: what could be read of it. By position in the file. Musher's own programs run
// with --check, each for `patience` at most; no other program runs.
std::vector<Diagnostic> CheckPrograms(const MachineConfig& config,
                                      Duration patience = Milliseconds(5000));

}  // namespace musher::cli
