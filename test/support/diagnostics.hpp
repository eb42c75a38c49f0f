#pragma once
// The diagnostics of a file as a person reads them.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"

namespace musher::testing {

inline std::vector<std::string> Lines(const std::vector<Diagnostic>& diagnostics) {
  std::vector<std::string> lines;
  for (const Diagnostic& found : diagnostics) lines.push_back(FormatDiagnostic(found));
  return lines;
}

// The first one of a file that is refused.
template <class Reading>
std::string FirstError(const Reading& reading) {
  EXPECT_FALSE(reading.config);
  return reading.diagnostics.empty() ? "" : FormatDiagnostic(reading.diagnostics.front());
}

}  // namespace musher::testing
