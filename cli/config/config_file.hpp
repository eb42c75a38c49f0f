#pragma once
// Reads and validates a command's config and prints the diagnostics.

#include <optional>
#include <string>
#include <vector>

#include "musher/cli/console/console.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/config/user_rules.hpp"

namespace musher::cli {

// Reads the config `file`. Diagnostics go to stderr; in JSON mode errors also become the result
// document. nullopt: the config is invalid and everything is already printed.
std::optional<MachineConfig> LoadConfig(const std::string& file, Console& console);

// ReadRulesOf() with the place of the key in the config.
UserRulesReading RulesOf(const MachineConfig& config);

// Where the file of the rules lies in `folder`: "etc/rules.txt"; "": it is not below it, or the
// config names none.
std::string RulesBelow(const MachineConfig& config, const std::string& folder);

// Reads the rules of the file of --rules; "": those that the config names. Prints what is wrong and
// returns false.
bool LoadUserRules(const std::string& file, const MachineConfig& config, Console& console,
                   UserRules& rules);

}  // namespace musher::cli
