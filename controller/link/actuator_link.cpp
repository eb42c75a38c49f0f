#include "musher/controller/link/actuator_link.hpp"

#include "musher/controller/link/cyberdog_link.hpp"
#include "musher/controller/link/musher_link.hpp"
#include "musher/controller/link/ros2_link.hpp"

namespace musher {

Result<std::unique_ptr<ActuatorLink>> MakeLink(transport::Node& node, const MachineConfig& config,
                                               std::size_t actuator, ActuatorLink::Emit emit) {
  switch (config.actuators[actuator].protocol) {
    case Protocol::kMusher:
      break;
    case Protocol::kCyberdog:
      return CyberdogLink::Make(node, config, actuator, std::move(emit));
    case Protocol::kRos2Lifecycle:
      return Ros2Link::Make(node, config, actuator, std::move(emit));
  }
  return MusherLink::Make(node, config, actuator, std::move(emit));
}

}  // namespace musher
