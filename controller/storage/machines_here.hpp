#pragma once
// The machines that this host has or had in a namespace and domain, with or without a controller:
//
//   by their state folders   of the controller that leads here, and of the default places
//   by their processes       MUSHER_CONFIG or --config of the actuators that run here
//   by their configs         given ones, and robot.toml of the working directory
//
// An emergency stop must reach every actuator of a machine, also on other hosts. These actuators
// are known from the config, and from what the last controller has stored. What this user may not
// read may belong to a machine with other hosts, whatever the readable configs say.
//
// Threads: any; it reads /proc and the disk.

#include <string>
#include <vector>

#include "musher/controller/client/machine_here.hpp"

namespace musher {

// A machine may be found several times. An entry may have no more than `unread`, and the actuators
// of this host that may belong to the machine. `configs`: files to read as well.
std::vector<MachineHere> MachinesHere(int domain_id, const std::string& name_space,
                                      const std::vector<std::string>& configs = {});

}  // namespace musher
