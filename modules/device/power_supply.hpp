#pragma once
// The host's own battery as the kernel shows it, by default under /sys/class/power_supply: a folder
// for each supply with a file for each value.

#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/modules/device/battery.hpp"

namespace musher::device {

inline constexpr const char* kPowerSupplyFolder = "/sys/class/power_supply";

// Reads the battery `name`, or where that is empty the first one by name that feeds this host (not
// one of a mouse). What the kernel does not give is not measured; that there is no such battery or
// no charge is an Error with a module code of Bms. Blocks as long as the kernel's driver does.
Result<BatteryReading> ReadHostBattery(const std::string& folder, const std::string& name);

}  // namespace musher::device
