#pragma once
// Reads the file of a device's registers; README.md in this folder explains its keys.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/device/i2c_registers.hpp"

namespace musher::device {

// The names of values that a device knows.
struct RegisterNames {
  std::vector<std::string_view> known;  // empty: any name of a topic
  std::string_view needed;              // empty: none
};

// Never throws; an unreadable file is a diagnostic.
Parsed<I2cProtocol> ReadI2cFile(const std::string& path, const RegisterNames& names);

// The same for a text; `path` is what diagnostics refer to.
Parsed<I2cProtocol> ReadI2cText(std::string_view text, const std::string& path,
                                const RegisterNames& names);

}  // namespace musher::device
