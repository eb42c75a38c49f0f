#pragma once
// What `set` and `down` have in common: ask for a switch, wait for its end, say how it ended.

#include <string>

#include "musher/controller/cli/console.hpp"
#include "musher/controller/cli/options.hpp"

namespace musher::cli {

// `actuator` empty: the whole machine.
ExitCode RequestSwitch(const std::string& target, const std::string& actuator,
                       const GlobalOptions& global, Console& console);

}  // namespace musher::cli
