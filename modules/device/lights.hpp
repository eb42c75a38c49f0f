#pragma once
// Which lights the module itself asks for, as requests to its own arbiter. Plain values, no IO.

#include <vector>

#include "musher/messages/protocol/device.hpp"

namespace musher::device {

using LightRequests = std::vector<msg::LedExecute::Request>;

// By the battery's charge. A low or charging battery is shown as client `bms`, before the lights of
// applications; otherwise its colour is the ground that `system` shows and `bms` releases, so that
// the others can be seen.
LightRequests BatteryLights(int percent, bool charging);

// In low power the tail light is off; else client `lowpower` has none. When low power is left the
// tail breathes in blue, as the ground that `system` shows, until the battery's colour comes.
LightRequests LowPowerLights(bool low_power);
LightRequests LeavingLowPowerLights();

// The robot goes down: as client `lowpower`, so that nothing hides it.
LightRequests ShutdownLights();

}  // namespace musher::device
