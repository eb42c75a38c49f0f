#pragma once
// The command-line tools of musher-meilin for trees, beside the actuator and the tools for plans
// (plan/tool.hpp). Each gets the command line from its own name on, and returns the exit code.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"

namespace musher::meilin {

// For `musher-meilin check`: every error of a tree or a match config, with its place. Nothing: the
// file is neither.
std::optional<std::vector<Diagnostic>> CheckTreeOrMatch(const std::string& file);
// musher-meilin models: the nodes as XML, for Groot2 and `musher tree check --models`.
int PrintModels(int argc, const char* const* argv);

}  // namespace musher::meilin
