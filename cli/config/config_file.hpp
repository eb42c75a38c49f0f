#pragma once
// Reads and validates a command's config and prints the diagnostics.

#include <optional>
#include <string>
#include <vector>

#include "musher/cli/console/console.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/config/stable_rule.hpp"

namespace musher::cli {

// Reads the config `file`. Diagnostics go to stderr; in JSON mode errors also become the result
// document. nullopt: the config is invalid and everything is already printed.
std::optional<MachineConfig> LoadConfig(const std::string& file, Console& console);

// Reads the file of --rules; "": there are none. Prints what is wrong and returns false.
bool LoadStableRules(const std::string& file, const MachineConfig& config, Console& console,
                     std::vector<StableRule>& rules);

}  // namespace musher::cli
