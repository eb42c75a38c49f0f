#pragma once
// The TOML file of a module of your own, read as Musher reads its own files: all faults at once, as
// "file:line:column: error: …", with what was expected and what was probably meant.

#include <functional>
#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/toml/table_reader.hpp"

namespace musher {

// `read` asks the file's table for the keys it knows; keys it does not ask for are faults. The
// Error's message has a line for each fault; warnings go to stderr. Never throws.
Result<> ReadModuleFile(const std::string& path,
                        const std::function<void(config_toml::TableReader&)>& read);

}  // namespace musher
