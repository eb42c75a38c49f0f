#pragma once
// How ROS 2 processes and a machine discover each other: the environment that a ROS 2 process
// needs, and why a process does not discover the machine with the environment that it has.
//
// Pure functions of environments; threads: any.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/network_profile.hpp"

namespace musher::transport {

using Environment = std::map<std::string, std::string>;

// The environment of this process.
Environment OwnEnvironment();

// CYCLONEDDS_URI for ROS 2 on multicast over the loopback, where a machine of the profile "local"
// is. Without a limit to the number of processes.
extern const char* const kRosOnLoopback;

// The same with interfaces to other hosts, for a machine of the profile "lan".
std::string RosOnInterfaces(const std::vector<std::string>& outer);

// Whether a CYCLONEDDS_URI replaces the settings of the profile. Two values do not: kRosOnLoopback
// in the profile "local", which is on the loopback, too (a person exports it for ROS 2's tools);
// and RosOnInterfaces() in the profile "lan" (a program inherits it from the ROS 2 process that has
// started it).
bool ReplacesProfile(TransportProfile profile, std::string_view uri);

// What a ROS 2 process needs beside `environment` to meet a machine of this profile, with these
// outer interfaces (see OuterInterfaces()). What the environment sets already is left as it is.
Environment RosEnvironment(TransportProfile profile, const Environment& environment,
                           const std::vector<std::string>& outer = {});

// Ends the message that `program` was not found: how a person gets `ros2`; empty for any other.
std::string MissingProgramHint(std::string_view program);

// Why a ROS 2 process in the environment `node` does not discover a machine of this profile with
// processes in the environment `machine`: sentences with the necessary changes; empty without a
// known obstacle.
std::vector<std::string> RosObstacles(TransportProfile profile, const Environment& machine,
                                      const Environment& node);

}  // namespace musher::transport
