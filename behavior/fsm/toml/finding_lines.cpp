#include "musher/behavior/fsm/toml/finding_lines.hpp"

#include <utility>

#include "musher/base/diagnostic.hpp"

namespace musher::fsm {

std::string FindingLines(config_toml::Findings&& findings, const std::string& file,
                         std::string_view text) {
  std::string lines;
  for (const Diagnostic& diagnostic : std::move(findings).Take(file, text)) {
    lines += (lines.empty() ? "" : "\n") + FormatDiagnostic(diagnostic);
  }
  return lines;
}

}  // namespace musher::fsm
