#pragma once
// The bytes of a config file.

#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>

#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::config_toml {

// No more than `most` of them and one, so that the caller sees what is too large and nobody reads
// it all. The Error's message says why there are none. Never throws.
Result<std::string> ReadTextFile(const std::string& path, std::size_t most);

// The same of a module's own file: an Error also when it is larger than 1 MiB.
Result<std::string> ReadModuleText(const std::string& path);

// What read(text, path) makes of a module's own file: an optional value and the diagnostics. Of one
// that cannot be read that is the only diagnostic.
template <class Read>
auto ReadFileWith(const std::string& path, const Read& read)
    -> std::invoke_result_t<Read, const std::string&, const std::string&> {
  const Result<std::string> text = ReadModuleText(path);
  if (!text) return {std::nullopt, {{path, 0, 0, Severity::kError, text.error().message}}};
  return read(text.value(), path);
}

}  // namespace musher::config_toml
