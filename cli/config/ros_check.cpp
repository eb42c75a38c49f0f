#include "musher/cli/config/ros_check.hpp"

#include <string>

#include "musher/cli/config/config_places.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {

std::vector<Diagnostic> CheckRos(const MachineConfig& config,
                                 const transport::Environment& environment) {
  std::vector<Diagnostic> found;
  const ConfigPlaces places(config.file);
  transport::DdsOptions options;
  options.profile = config.transport;
  const auto profile = transport::Profile(options);
  if (!profile) return found;  // `up` says what is wrong with it
  for (const ActuatorConfig& actuator : config.actuators) {
    if (actuator.protocol != Protocol::kRos2Lifecycle) continue;
    transport::Environment node = environment;
    const bool ours = !actuator.command.empty();
    if (ours) {
      for (const auto& [name, value] : actuator.env) node[name] = value;
      node.merge(transport::RosEnvironment(profile.value(), node, config.interfaces));
    }
    const int line = places.LineOf("actuator." + actuator.name, ours ? "env" : "protocol");
    const std::string where =
        "in 'actuator." + actuator.name + "': " +
        (ours ? "the ROS 2 node does not discover the machine: "
              : "a ROS 2 node that is started in this shell does not discover the machine: ");
    for (const std::string& obstacle :
         transport::RosObstacles(profile.value(), environment, node)) {
      found.push_back({config.file, line, line == 0 ? 0 : 1, Severity::kWarning, where + obstacle});
    }
  }
  return found;
}

}  // namespace musher::cli
