#pragma once
// An error, warning or note about a file that a person wrote, with its location.

#include <string>
#include <vector>

namespace musher {

enum class Severity { kNote, kWarning, kError };

struct Diagnostic {
  std::string file;
  int line = 0;    // from 1; 0 when it is about the file as a whole
  int column = 0;  // from 1, in bytes; 0 with line 0
  Severity severity = Severity::kError;
  std::string message;

  friend bool operator==(const Diagnostic&, const Diagnostic&) = default;
};

std::string SeverityName(Severity severity);  // "note", "warning", "error"

// "file:line:column: error: message", the form that editors and compilers share.
std::string FormatDiagnostic(const Diagnostic& diagnostic);

bool HasError(const std::vector<Diagnostic>& diagnostics);

}  // namespace musher
