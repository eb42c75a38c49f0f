#include "musher/base/toml/module_file.hpp"

#include <iostream>
#include <utility>
#include <variant>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/file.hpp"

namespace musher {

Result<> ReadModuleFile(const std::string& path,
                        const std::function<void(config_toml::TableReader&)>& read) {
  const Result<std::string> text = config_toml::ReadModuleText(path);
  if (!text) return Error{kCodeParametersInvalid, path + ": error: " + text.error().message};
  config_toml::Findings findings;
  const auto document = config_toml::ParseDocument(text.value());
  if (const auto* fault = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(fault->at, fault->message);
  } else {
    config_toml::TableReader root(std::get<config_toml::Table>(document), {1, 1}, "", findings);
    read(root);
    root.RefuseOthers();
  }
  const bool faulty = findings.HasErrors();
  std::string lines;
  for (const Diagnostic& diagnostic : std::move(findings).Take(path, text.value())) {
    lines += (lines.empty() ? "" : "\n") + FormatDiagnostic(diagnostic);
  }
  if (faulty) return Error{kCodeParametersInvalid, lines};
  if (!lines.empty()) std::cerr << lines << std::endl;
  return Ok();
}

}  // namespace musher
