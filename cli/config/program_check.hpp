#pragma once
// Checks what a state config names on this computer: programs, folders, and the files that
// musher-exec and Musher's own modules read. For `musher check`, which may run on another computer
// than the robot: there a missing program or folder is a warning.

#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// The diagnostics, by position in the file; of a faulty config, of the part that could be read. A
// program or folder that is missing here has the severity `missing`. Runs Musher's own programs
// with --check, each for at most `timeout`; runs no other program.
std::vector<Diagnostic> CheckPrograms(const MachineConfig& config,
                                      Duration timeout = Milliseconds(30000),
                                      Severity missing = Severity::kWarning);

}  // namespace musher::cli
