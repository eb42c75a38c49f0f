#pragma once
// The lights that the module itself requests from its own arbiter. Plain values, no IO.

#include <vector>

#include "musher/messages/protocol/device.hpp"

namespace musher::device {

using LightRequests = std::vector<msg::LedExecute::Request>;

// By the battery's charge. A low or charging battery is shown as client `bms`, before the lights
// of applications; otherwise `system` shows its colour and `bms` releases, so that the other
// clients can be seen.
LightRequests BatteryLights(int percent, bool charging);

// In low power the tail light is off; else client `lowpower` has no request. When low power is
// left the tail breathes in blue as `system`, until the battery's colour comes.
LightRequests LowPowerLights(bool low_power);
LightRequests LeavingLowPowerLights();

// The robot shuts down: as client `lowpower`, so that no other client hides it.
LightRequests ShutdownLights();

}  // namespace musher::device
