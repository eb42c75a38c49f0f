#pragma once
// The bytes of a config file.

#include <cstddef>
#include <string>

#include "musher/lifecycle/result.hpp"

namespace musher::config_toml {

// No more than `most` of them and one, so that the caller sees what is too large and nobody reads
// it all. The Error's message says why there are none. Never throws.
Result<std::string> ReadTextFile(const std::string& path, std::size_t most);

}  // namespace musher::config_toml
