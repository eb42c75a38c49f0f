#pragma once
// Reads the TOML file of a user's module like Musher's own files: all errors at once, as
// "file:line:column: error: …", with the expected value and a suggestion.

#include <functional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher {

// `read` reads the keys it knows from the file's table; keys that it does not read are errors. The
// Error's message has a line for each error; warnings go to stderr. Never throws.
Result<> ReadModuleFile(const std::string& path,
                        const std::function<void(config_toml::TableReader&)>& read);

}  // namespace musher
