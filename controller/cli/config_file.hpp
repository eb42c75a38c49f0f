#pragma once
// A command's config: read, judged, its findings told.

#include <optional>
#include <string>

#include "musher/controller/cli/console.hpp"
#include "musher/lifecycle/config.hpp"

namespace musher::cli {

// The config of `file`. Findings go to the complaint stream, in JSON mode those that are errors
// become the result document. nullopt: it is not valid, and all is said.
std::optional<MachineConfig> LoadConfig(const std::string& file, Console& console);

}  // namespace musher::cli
