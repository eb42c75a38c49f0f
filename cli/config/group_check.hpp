#pragma once
// Whether this host has the group that may read the logs of a machine: for `musher check` and
// `musher up`.

#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

std::vector<Diagnostic> CheckLogGroup(const MachineConfig& config);

}  // namespace musher::cli
