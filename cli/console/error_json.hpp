#pragma once
// What is wrong, as the JSON document of `--json`. As with all of them, keys may be added, none is
// renamed or removed.

#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/cli/console/exit_code.hpp"

namespace musher::cli {

std::string FailureJson(const Failure& failure);
// The faults of a file, or of several; none: it is valid.
std::string CheckJson(const std::vector<Diagnostic>& diagnostics);
// The failure of a command with an invalid config.
std::string BadConfigJson(const std::string& file, const std::vector<Diagnostic>& diagnostics);

}  // namespace musher::cli
