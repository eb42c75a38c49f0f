#pragma once
// A device on an I2C bus of Linux (/dev/i2c-1, of its module i2c-dev), by the SMBus calls that
// nearly every bus has: a byte, a word, and a block of four bytes. They are the kernel's own, of
// which libi2c has thin wrappers.
//
// A kernel driver that has the device keeps it: reading beside it would disturb both.
//
// Threads: one at a time.

#include "musher/modules/device/i2c_bus.hpp"

namespace musher::device {

// I2cBus::Open of this computer.
Result<std::unique_ptr<I2cBus>> OpenI2cFile(const std::string& bus, std::uint8_t address);

}  // namespace musher::device
