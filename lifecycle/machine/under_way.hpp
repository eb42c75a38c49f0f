#pragma once
// What a machine has under way: where that is nothing, it is stable. The controller checks the
// user's rules then (rule_monitor.hpp), and the simulation all that has to hold at rest.

#include <functional>
#include <string>

#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

// "a switch to Active is under way", "arm has a command to Active"; empty: nothing, or the machine
// is stopped. What the policy waits for does not count. `may_come`: whether an actuator that is not
// present may still become so by itself; false where nothing of it runs.
std::string UnderWay(const MachineConfig& config, const Machine& machine,
                     const std::function<bool(ActuatorIndex)>& may_come);

}  // namespace musher
