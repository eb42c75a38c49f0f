#pragma once
// The host's own battery as the kernel reports it, by default under /sys/class/power_supply: a
// folder for each supply with a file for each value.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/device/battery.hpp"

namespace musher::device {

inline constexpr const char* kPowerSupplyFolder = "/sys/class/power_supply";

// Reads the battery `name`, or if that is empty the first one by name that feeds this host (not
// that of a mouse). Values that the kernel does not have are kNotMeasured; a missing battery or
// charge is an Error with a code of module Bms. Blocks as long as the kernel's driver does.
Result<BatteryReading> ReadHostBattery(const std::string& folder, const std::string& name);

}  // namespace musher::device
