#pragma once
// The restart of an actuator, by the controller that leads.
//
// Threads: one; waits until the actuator is back.

#include <optional>
#include <string>

#include "musher/cli/machine/link.hpp"

namespace musher::cli {

// nullopt: its process was started again, and it is where the machine is.
std::optional<Failure> RestartActuator(Link& link, const std::string& actuator);

}  // namespace musher::cli
