#include "musher/controller/link/actuator_link.hpp"

#include <string>
#include <utility>

#include "musher/controller/link/musher_link.hpp"
#include "musher/controller/link/ros2_link.hpp"

namespace musher {

Result<std::unique_ptr<ActuatorLink>> MakeLink(transport::Node& node, const MachineConfig& config,
                                               ActuatorIndex actuator, ActuatorLink::Emit emit,
                                               const LinkMakers& extensions) {
  const ActuatorConfig& own = config.actuators[actuator];
  if (own.protocol == Protocol::kMusher) {
    return MusherLink::Make(node, config, actuator, std::move(emit));
  }
  if (own.protocol == Protocol::kRos2Lifecycle) {
    return Ros2Link::Make(node, config, actuator, std::move(emit));
  }
  const auto maker = extensions.find(own.protocol);
  if (maker == extensions.end()) {
    return Error{kCodeUnSupport, "actuator '" + own.name + "' has the protocol '" +
                                     std::string(ProtocolName(own.protocol)) +
                                     "', which the controller of this program does not have: "
                                     "give it the extension for that protocol, such as "
                                     "MachineController({cyberdog::Extension()})"};
  }
  return maker->second(node, config, actuator, std::move(emit));
}

}  // namespace musher
