#pragma once
// A power-off or reboot that lies ahead of the robot, as the state folder's file `policy` has it:
// with the boot and the time of its decision, which later saves keep.
//
// It is forgotten after a boot, and kPowerKept after its decision: a controller that starts then
// would power off a robot that a person has switched on again.
//
// Threads: any; WhyPowerForgottenIn() reads the disk.

#include <string>

#include "musher/base/time.hpp"
#include "musher/lifecycle/machine/policy_state.hpp"

namespace musher {

inline constexpr Duration kPowerKept = std::chrono::minutes(10);

// The line of it: "power off BOOT MILLISECONDS", the time since that boot. `stored`: what the file
// has had; a decision that still counts there keeps its time.
std::string PowerLine(PowerAhead ahead, const std::string& stored);

// What still lies ahead, by the text of the file.
PowerAhead PowerIn(const std::string& policy);

// Why what is stored in a folder does not lie ahead any more; empty: nothing is, or it does.
std::string WhyPowerForgottenIn(const std::string& state_dir);

}  // namespace musher
