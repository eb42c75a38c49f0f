#pragma once
// How old a command is, by the clock of the actuator that it is meant for. Pure.

#include <optional>

#include "musher/base/result.hpp"
#include "musher/lifecycle/actuator/actuator_core.hpp"

namespace musher {

// Why `command` may not begin at `now`: it is older than its budget (Timeout), or its times are
// invalid (ParametersInvalid); nullopt where it may.
std::optional<Error> CheckAge(const SwitchCommand& command, Time now);

}  // namespace musher
