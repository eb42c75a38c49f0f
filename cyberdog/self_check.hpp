#pragma once
// The progress of the start for CyberDog's app: `self_check_status`, from the machine's record of
// its actuators. Pure.

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/messages/protocol/manager.hpp"

namespace musher::cyberdog {

// The code is the progress of the start and whether something is wrong now; the description is JSON
// with a code for each part of the robot: -1 unknown (yet), 0 well.
msg::SelfCheckStatus SelfCheckOf(const MachineConfig& config, const Machine& machine);

}  // namespace musher::cyberdog
