#pragma once
// The credentials that a controller and the actuators that it starts need for [security].

#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// The identities whose credentials `up` checks; none without [security].
std::vector<std::string> KeyedIdentities(const MachineConfig& config);

// For `musher check`, which may run on another computer than the robot, so that all findings are
// warnings: what `up` would refuse.
std::vector<Diagnostic> CheckKeys(const MachineConfig& config);

}  // namespace musher::cli
