#pragma once
// The output of `musher diff`.

#include <string>

#include "musher/cli/config/config_diff.hpp"

namespace musher::cli {

// A block for each table, then what the changes take on a robot that runs.
std::string DiffText(const ConfigDiff& diff, bool colour);
std::string DiffJson(const ConfigDiff& diff);

}  // namespace musher::cli
