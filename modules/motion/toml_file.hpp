#pragma once
// Reads a TOML file of the motion manager and gathers what is wrong with it.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::motion {

// Its text, or why there is none. Never throws.
Result<std::string> ReadText(const std::string& path);

Diagnostic Unreadable(const std::string& path, const std::string& reason);

}  // namespace musher::motion
