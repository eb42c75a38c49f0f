#pragma once
// Shared by `set` and `down`: requests a switch, waits for its outcome and prints it.

#include <string>

#include "musher/cli/console/console.hpp"
#include "musher/cli/console/options.hpp"

namespace musher::cli {

// `actuator` empty: the whole machine.
ExitCode RequestSwitch(const std::string& target, const std::string& actuator,
                       const GlobalOptions& global, Console& console);

}  // namespace musher::cli
