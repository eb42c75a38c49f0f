#pragma once
// Reads OpenMetrics 1.0 text as strictly as the standard permits, line by line along its ABNF, and
// reports everything that is not allowed. Written from the standard, without a line of the writer.

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace musher::testing {

using ParsedLabels = std::vector<std::pair<std::string, std::string>>;

struct ParsedSample {
  std::string name;
  ParsedLabels labels;  // unescaped, in their order
  double value = 0;
};

struct ParsedFamily {
  std::string name;
  std::string type;
  std::string help;
  std::string unit;
  bool has_help = false;
  bool has_unit = false;
  std::vector<ParsedSample> samples;
};

struct ParsedMetrics {
  std::vector<ParsedFamily> families;
  std::vector<std::string> errors;  // "line 3: …"

  const ParsedFamily* Find(std::string_view family) const;
  // The value of the sample of that name with exactly these labels.
  std::optional<double> Value(std::string_view sample, const ParsedLabels& labels = {}) const;
};

ParsedMetrics ParseOpenMetrics(std::string_view text);

}  // namespace musher::testing
