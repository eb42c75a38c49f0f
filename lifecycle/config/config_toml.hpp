#pragma once
// Reads a state config from TOML. All errors are reported at once, with their locations; of syntax
// errors only the first, since the text after it cannot be parsed. A CyberDog state TOML works
// unchanged.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/config/user_rules.hpp"

namespace musher {

struct ConfigReading {
  std::optional<MachineConfig> config;  // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
  // What could be read of a faulty text: for more checks, never to be run.
  std::optional<MachineConfig> faulty = std::nullopt;
};

// Reads and checks the file at `path`. Files over 8 MiB and machines of more than 4096 actuators
// are refused. Never throws; an unreadable file is a diagnostic.
ConfigReading ReadConfigFile(const std::string& path);

// The same for a text; `path` is what diagnostics and relative paths refer to.
ConfigReading ReadConfigText(std::string_view text, const std::string& path);

// Whether this build can start processes on other hosts, which needs libsystemd: without, [host.*]
// is an error.
bool SupportsHosts();

// MachineConfig::hash of a text: 16 hex digits.
std::string ConfigHash(std::string_view text);

// The rules of the user that the config names (MachineConfig::rules_file), from their file; none
// without a name. A file that cannot be read is the only diagnostic, of the config.
UserRulesReading ReadRulesOf(const MachineConfig& config);

// For programs: the config at `path` (see base/config_path.hpp), or all its errors as one message
// of several lines. Warnings are not reported.
Result<MachineConfig> ReadValidConfig(const std::string& path);

}  // namespace musher
