#pragma once
// CyberDog's protocol and manager for a controller: actuators with `protocol = "cyberdog"`, and the
// interfaces and the keys of `[policy] manager = true`.

#include <string>

#include "musher/controller/extension.hpp"
#include "musher/cyberdog/serial_number.hpp"
#include "musher/cyberdog/voice_policy.hpp"

namespace musher::cyberdog {

// `serial_number`: of the robot's computer, as the manager reports it.
ControllerExtension Extension(std::string serial_number = ReadSerialNumber());

}  // namespace musher::cyberdog
