#pragma once
// The systemd of this host, which runs the processes of a machine with `units = "always"`: the one
// of the system for root, and a user's own for any other user.
//
// Threads: any. Looks at a few files in memory (/run), never at a disk.

#include <sys/types.h>

#include <map>
#include <string>

#include "musher/controller/process/process_runner.hpp"

namespace musher {

struct OwnSystemd {
  std::string socket;   // of its D-Bus
  std::string trouble;  // why it is not reached, with what to do; empty: the socket is there
};

// DBUS_SYSTEM_BUS_ADDRESS (root) and DBUS_SESSION_BUS_ADDRESS (any other user) name another D-Bus
// with a socket in the file system, as for all programs.
OwnSystemd FindOwnSystemd(const std::map<std::string, std::string>& environment, uid_t user);

// The unit of systemd that a process of this host belongs to, such as "musher-robot-arm.service" or
// "session-3.scope"; empty: none, or there is no such process.
std::string UnitOf(pid_t pid);

// What a child has from its controller and a unit has not: the environment, the working directory,
// and that a program without '/' is looked up in PATH. A variable that systemd would refuse, or has
// given to this process alone, is left out; so is what belongs to the controller's user if the unit
// has another `user`.
void InheritForUnit(const std::map<std::string, std::string>& environment, ProcessSpec& spec);

}  // namespace musher
