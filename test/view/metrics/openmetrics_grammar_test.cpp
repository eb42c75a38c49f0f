// The parser of the tests finds what is not allowed.

#include "musher/test/view/metrics/openmetrics_grammar.hpp"

#include <gmock/gmock.h>

namespace musher::testing::openmetrics_grammar_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::string_view kGood = R"(# HELP a A \"gauge\".
# TYPE a gauge
a{x="1\n\\\""} 1
a -1.5e-3
# HELP b_seconds B.
# TYPE b_seconds counter
# UNIT b_seconds seconds
b_seconds_total 3
# HELP c C.
# TYPE c info
c_info{v="1"} 1
# HELP d D.
# TYPE d stateset
d{d="on"} 1
d{d="off"} 0
# HELP e E.
# TYPE e histogram
e_bucket{le="0.5"} 1
e_bucket{le="+Inf"} 2
e_sum 7
e_count 2
# EOF
)";

// `kGood` with one text replaced.
std::string With(std::string_view words, std::string_view by) {
  std::string text(kGood);
  const auto at = text.find(words);
  EXPECT_NE(at, std::string::npos) << words;
  return text.replace(at, words.size(), by);
}

TEST(OpenMetricsGrammar, AcceptsEveryTypeThatMusherWrites) {
  const ParsedMetrics parsed = ParseOpenMetrics(kGood);
  EXPECT_THAT(parsed.errors, IsEmpty());
  EXPECT_EQ(parsed.Value("a", {{"x", "1\n\\\""}}), 1);
  EXPECT_EQ(parsed.Value("b_seconds_total"), 3);
  EXPECT_EQ(parsed.Find("a")->help, "A \"gauge\".");
}

TEST(OpenMetricsGrammar, FindsEachViolation) {
  const struct {
    std::string_view words, by, error;
  } cases[] = {
      {"# EOF\n", "", "# EOF is missing"},
      {"# EOF\n", "# EOF\n\n", "follows # EOF"},
      {"# EOF\n", "# EOF", "does not end with a line feed"},
      {"c_info", "c", "not the _info"},
      {"c_info{v=\"1\"} 1", "c_info{v=\"1\"} 2", "info is not 1"},
      {"b_seconds_total", "b_seconds", "not the _total"},
      {"_total 3", "_total -3", "negative"},
      {"UNIT b_seconds seconds", "UNIT b_seconds bytes", "its unit"},
      {"# TYPE a gauge", "# TYPE a gauge\n# TYPE a gauge", "a second TYPE"},
      {"# TYPE a gauge", "# TYPE a meter", "not a type"},
      {"# TYPE a gauge\n", "", "no TYPE"},
      {"# HELP b_seconds B.\n", "", "no HELP"},
      {"# HELP a A \\\"gauge\\\".", "# HELP a A \"gauge\".", "not an escaped string"},
      {"# HELP c C.", "# HELP a A.", "the family a comes twice"},
      {"a -1.5e-3", "a{x=\"1\\n\\\\\\\"\"} 2", "the sample comes twice"},
      {"a -1.5e-3", "a -1.5e-3\n# HELP a Again.", "follows its samples"},
      {"a -1.5e-3", "a one", "not a number"},
      {"a -1.5e-3", "a  1", "not a number"},
      {"a -1.5e-3", "a-b 1", "not a metric name"},
      {"a -1.5e-3", "a{} 1", "malformed labels"},
      {"a -1.5e-3", "a{x=\"\\q\"} 1", "malformed labels"},
      {"a -1.5e-3", "a{__x=\"\"} 1", "not a label name"},
      {"a -1.5e-3", "a{x=\"\",x=\"\"} 1", "the label x comes twice"},
      {"a -1.5e-3", "a{x=\"\xFF\"} 1", "not UTF-8"},
      {"a -1.5e-3", "a{x=\"\xED\xA0\x80\"} 1", "not UTF-8"},
      {"a -1.5e-3", "a{x=\"\xC0\x80\"} 1", "not UTF-8"},
      {"a -1.5e-3", "z 1", "z is not of a"},
      {"d{d=\"off\"} 0", "d{d=\"off\"} 2", "neither 0 nor 1"},
      {"d{d=\"off\"} 0", "d{e=\"off\"} 0", "a state without its label"},
      {"d{d=\"off\"} 0", "d{x=\"1\",d=\"on\"} 1\nd{d=\"off\"} 0", "are apart"},
      {"e_bucket{le=\"+Inf\"} 2\n", "", "without the bucket +Inf"},
      {"le=\"+Inf\"} 2", "le=\"+Inf\"} 0", "not cumulative"},
      {"le=\"0.5\"", "le=\"5\"", "not a bound"},
      {"e_sum", "e_bucket{le=\"0.7\"} 2\ne_sum", "without the bucket +Inf"},
      {"e_count 2", "e_count 3", "not that of the bucket +Inf"},
  };
  for (const auto& one : cases) {
    EXPECT_THAT(ParseOpenMetrics(With(one.words, one.by)).errors,
                Contains(HasSubstr(std::string(one.error))))
        << one.words << " -> " << one.by;
  }
}

}  // namespace musher::testing::openmetrics_grammar_test
