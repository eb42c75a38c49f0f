#pragma once
// Reads a config file, and passes its text to a reader.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "musher/base/diagnostic.hpp"
#include "musher/base/result.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/base/toml/findings.hpp"

namespace musher::config_toml {

// At most `most` + 1 bytes, so that the caller detects a file that is too large without reading all
// of it. The Error's message says why there are none. Never throws.
Result<std::string> ReadTextFile(const std::string& path, std::size_t most);

// The same for a module's own file: an Error also when it is larger than 1 MiB.
Result<std::string> ReadModuleText(const std::string& path);

// The value that read(root, findings) returns for a text's table, where it has no errors, and the
// diagnostics: a Reading has both, in this order. `path` is the file name in diagnostics.
template <class Reading, class Read>
Reading ReadTextWith(std::string_view text, const std::string& path, const Read& read) {
  Findings findings;
  Reading reading;
  auto& [value, diagnostics] = reading;
  const auto document = ParseDocument(text);
  if (const auto* fault = std::get_if<SyntaxFault>(&document)) {
    findings.Error(fault->at, fault->message);
  } else {
    auto found = read(std::get<Table>(document), findings);
    if (!findings.HasErrors()) value = std::move(found);
  }
  diagnostics = std::move(findings).Take(path, text);
  return reading;
}

// The result of read(text, path) for a module's own file: an optional value and the diagnostics.
// Where the file cannot be read, that is the only diagnostic.
template <class Read>
auto ReadFileWith(const std::string& path, const Read& read)
    -> std::invoke_result_t<Read, const std::string&, const std::string&> {
  const Result<std::string> text = ReadModuleText(path);
  if (!text) return {std::nullopt, {{path, 0, 0, Severity::kError, text.error().message}}};
  return read(text.value(), path);
}

}  // namespace musher::config_toml
