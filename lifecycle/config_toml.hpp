#pragma once
// Reads a state config from TOML. Every fault is found in one go and located; of syntax faults only
// the first, since what follows one cannot be judged. A CyberDog state TOML works unchanged.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher {

struct ConfigReading {
  std::optional<MachineConfig> config;  // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
  // Of a faulty text what could be read: for more checks, never to be run.
  std::optional<MachineConfig> faulty = std::nullopt;
};

// Reads and judges the file at `path`. Files over 8 MiB and machines of more than 4096 actuators
// are refused. Never throws; an unreadable file is a diagnostic.
ConfigReading ReadConfigFile(const std::string& path);

// The same for a text; `path` is what diagnostics and relative paths refer to.
ConfigReading ReadConfigText(std::string_view text, const std::string& path);

// MachineConfig::hash of a text: 16 hex digits.
std::string ConfigHash(std::string_view text);

// For programs: the config at `path` (empty: the one MUSHER_CONFIG names), or all its faults as one
// message of several lines. Warnings are not told.
Result<MachineConfig> ReadValidConfig(std::string path);

}  // namespace musher
