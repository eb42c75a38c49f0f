#pragma once
// A config file: its bytes, and what a reader makes of them.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "musher/lifecycle/diagnostic.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/toml/document.hpp"
#include "musher/lifecycle/toml/findings.hpp"

namespace musher::config_toml {

// No more than `most` of them and one, so that the caller sees what is too large and nobody reads
// it all. The Error's message says why there are none. Never throws.
Result<std::string> ReadTextFile(const std::string& path, std::size_t most);

// The same of a module's own file: an Error also when it is larger than 1 MiB.
Result<std::string> ReadModuleText(const std::string& path);

// The value that read(root, findings) makes of a text's table, where nothing is wrong with it, and
// the diagnostics: a Reading has both, in this order. `path` is what diagnostics refer to.
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
