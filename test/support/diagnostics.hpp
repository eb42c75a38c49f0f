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

// A row of a table of wrong configs: why it is wrong, its text, and a part of each of its
// diagnostics.
struct WrongConfig {
  const char* why;
  std::string text;
  std::vector<std::string> said;
};

// Each text has exactly these diagnostics, in this order, and is refused if one of them is an
// error. `read` reads a text.
template <class Read>
void ExpectDiagnostics(const Read& read, const std::vector<WrongConfig>& rows) {
  for (const WrongConfig& row : rows) {
    SCOPED_TRACE(row.why);
    const auto reading = read(row.text);
    const std::vector<std::string> lines = Lines(reading.diagnostics);
    bool refused = false;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      refused = refused || lines[i].find("error: ") != std::string::npos;
      const std::string expected = i < row.said.size() ? row.said[i] : "no further line";
      EXPECT_NE(lines[i].find(expected), std::string::npos) << lines[i] << "\n  for\n" << expected;
    }
    EXPECT_GE(lines.size(), row.said.size()) << "fewer lines than expected";
    EXPECT_EQ(reading.config.has_value(), !refused);
  }
}

}  // namespace musher::testing
