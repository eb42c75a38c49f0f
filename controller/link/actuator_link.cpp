#include "musher/controller/link/actuator_link.hpp"

#include "musher/controller/link/musher_link.hpp"

namespace musher {

Result<std::unique_ptr<ActuatorLink>> MakeLink(transport::Node& node, const MachineConfig& config,
                                               std::size_t actuator, ActuatorLink::Emit emit) {
  return MusherLink::Make(node, config, actuator, std::move(emit));
}

}  // namespace musher
