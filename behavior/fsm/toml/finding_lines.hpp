#pragma once
// All diagnostics of a text as one message.

#include <string>
#include <string_view>

#include "musher/base/toml/findings.hpp"

namespace musher::fsm {

// "file:line:column: error: …", a line each.
std::string FindingLines(config_toml::Findings&& findings, const std::string& file,
                         std::string_view text);

}  // namespace musher::fsm
