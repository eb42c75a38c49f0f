#pragma once
// Which files `musher deploy` copies to each host: what the actuators of that host name in a folder
// ROOT/current, and the keys of these actuators.
//
//   [actuator.eyes]
//   host = "vision"
//   command = ["/opt/robot/current/bin/eyes", "eyes.toml"]
//   cwd = "/opt/robot/current"
//   env.MUSHER_CONFIG = "/opt/robot/current/robot.toml"
//
// has the root /opt/robot, and bin/eyes, eyes.toml and robot.toml in its slot. They come from the
// folder FROM: FROM/vision/bin/eyes if that exists, for a host with a processor of its own, else
// FROM/bin/eyes. robot.toml is the config itself, with the file of its rules ([safety] rules)
// beside it.
//
// Threads: any; waits for the disk.

#include <map>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

struct HostFiles {
  const HostConfig* host = nullptr;
  std::string root;
  std::map<std::string, std::string> files;  // by path in the slot: where it is here
  std::vector<std::string> actuators;
};

struct DeployPlan {
  std::vector<HostFiles> hosts;
  std::vector<std::string> notes;  // what is not copied, and an actuator needs
};

// The error names all that is wrong, a line each.
Result<DeployPlan> PlanDeployment(const MachineConfig& config, const std::string& from);

// For which processor a program is: bytes 18 and 19 of its file, "3e 00"; empty: it is no program
// of a processor, such as a script.
std::string ProcessorOf(const std::string& file);

}  // namespace musher::cli
