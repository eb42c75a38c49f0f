#pragma once
// A device on an I2C bus, whose registers are read. i2c_file.hpp has those of Linux; a test has its
// own.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/modules/device/i2c_registers.hpp"

namespace musher::device {

class I2cBus {
 public:
  // `bus` is its file, "/dev/i2c-1". Fails with a sentence, and what to do.
  using Open =
      std::function<Result<std::unique_ptr<I2cBus>>(const std::string& bus, std::uint8_t address)>;

  virtual ~I2cBus() = default;

  // `bytes` is 1, 2 or 4. Blocks as long as the bus does. Fails with NetError when the device does
  // not answer or the bus is gone.
  virtual Result<RegisterBytes> Read(std::uint8_t address, std::size_t bytes) = 0;
};

}  // namespace musher::device
