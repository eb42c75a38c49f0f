#pragma once
// Reads the file of a device's frames. Its keys are those of CyberDog's embed_protocol; README.md
// in this folder explains them.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/parsed.hpp"
#include "musher/modules/device/can_protocol.hpp"

namespace musher::device {

// The names that a device knows.
struct CanNames {
  std::vector<std::string_view> fields;
  std::string_view needed_field;  // empty: none
  std::vector<std::string_view> commands;
  std::string_view needed_command;  // empty: none
  std::size_t data_bytes = 0;       // that a command of this device carries
};

// Never throws; an unreadable file is a diagnostic.
Parsed<CanProtocol> ReadCanFile(const std::string& path, const CanNames& names);

// The same for a text; `path` is what diagnostics refer to.
Parsed<CanProtocol> ReadCanText(std::string_view text, const std::string& path,
                                const CanNames& names);

}  // namespace musher::device
