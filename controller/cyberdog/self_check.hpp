#pragma once
// What CyberDog's app is told of the start: `self_check_status`, from what the machine knows of its
// actuators. Pure.

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/machine.hpp"
#include "musher/messages/protocol/manager.hpp"

namespace musher::cyberdog {

// The code says how far the start is and whether something is wrong now; the description is JSON
// with a code for each part of the robot: -1 not known (yet), 0 well.
msg::SelfCheckStatus SelfCheckOf(const MachineConfig& config, const Machine& machine);

}  // namespace musher::cyberdog
