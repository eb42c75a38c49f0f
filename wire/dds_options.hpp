#pragma once
// The DDS options that a state config has for one of its processes.

#include <optional>
#include <string>

#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::transport {

// The options that the config has for the process `identity`, with `node_name` as its node in the
// machine's namespace. An actuator discovers with the timing of a crowd from 64 processes on.
DdsOptions OptionsFor(const MachineConfig& config, const std::string& identity,
                      const std::string& node_name);

// The credentials of `identity`, if the config has keys.
std::optional<Credentials> CredentialsFor(const MachineConfig& config, const std::string& identity);
inline constexpr const char* kControllerIdentity = "controller";

// The ROS 2 node of a controller, in the namespace of its machine: its services are `/musher/…`.
inline constexpr const char* kControllerNode = "musher";

}  // namespace musher::transport
