#include "musher/view/metrics/exposition.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "musher/test/view/metrics/openmetrics_grammar.hpp"

namespace musher::view::exposition_test {

using musher::testing::ParsedMetrics;
using musher::testing::ParseOpenMetrics;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::string Finish(Exposition& text) {
  return std::move(text).Finish();
}

// One family of each type.
std::string AllTypes(MetricsFormat format) {
  DurationHistogram histogram;
  for (const double seconds : {0.005, 0.03, 2.5, 1000.0}) histogram.Observe(seconds);
  Exposition text(format);
  text.BeginGauge({"level_ratio", "How full.", "ratio"});
  text.Add(0.25);
  text.BeginCounter({"falls", "How often."});
  text.Add(std::uint64_t{3}, {{"leg", "left"}});
  text.BeginInfo({"robot", "Which."});
  text.Add(true, {{"name", "dog"}});
  text.BeginStateSet({"mood", "How."});
  text.AddStates(std::vector<std::string_view>{"good", "bad"}, "bad", {{"dog", "a"}});
  text.BeginHistogram({"walk_seconds", "How long.", "seconds"});
  text.AddHistogram(histogram, {{"to", "dock"}});
  return Finish(text);
}

TEST(Exposition, WritesOpenMetrics) {
  const std::string text = AllTypes(MetricsFormat::kOpenMetrics);
  EXPECT_THAT(ParseOpenMetrics(text).errors, IsEmpty()) << text;
  EXPECT_THAT(text, HasSubstr("# HELP level_ratio How full.\n# TYPE level_ratio gauge\n"
                              "# UNIT level_ratio ratio\nlevel_ratio 0.25\n"));
  EXPECT_THAT(text, HasSubstr("# TYPE falls counter\nfalls_total{leg=\"left\"} 3\n"));
  EXPECT_THAT(text, HasSubstr("# TYPE robot info\nrobot_info{name=\"dog\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("mood{dog=\"a\",mood=\"good\"} 0\nmood{dog=\"a\",mood=\"bad\"} 1\n"));
  EXPECT_TRUE(text.ends_with("walk_seconds_count{to=\"dock\"} 4\n# EOF\n"));
}

TEST(Exposition, WritesThePrometheusFormatWithItsNamesAndTypes) {
  const std::string text = AllTypes(MetricsFormat::kPrometheus);
  EXPECT_THAT(text, HasSubstr("# HELP falls_total How often.\n# TYPE falls_total counter\n"));
  EXPECT_THAT(text, HasSubstr("# TYPE robot_info gauge\n"));
  EXPECT_THAT(text, HasSubstr("# TYPE mood gauge\n"));
  EXPECT_THAT(text, Not(HasSubstr("# EOF")));
  EXPECT_THAT(text, Not(HasSubstr("# UNIT")));
}

TEST(Exposition, PutsADurationIntoTheBucketWhoseBoundItDoesNotExceed) {
  const ParsedMetrics parsed = ParseOpenMetrics(AllTypes(MetricsFormat::kOpenMetrics));
  const auto upto = [&](const char* le) {
    return parsed.Value("walk_seconds_bucket", {{"to", "dock"}, {"le", le}});
  };
  EXPECT_EQ(upto("0.005"), 1);
  EXPECT_EQ(upto("0.025"), 1);
  EXPECT_EQ(upto("0.05"), 2);
  EXPECT_EQ(upto("1.0"), 2);
  EXPECT_EQ(upto("2.5"), 3);
  EXPECT_EQ(upto("30.0"), 3);
  EXPECT_EQ(upto("+Inf"), 4);
  EXPECT_DOUBLE_EQ(*parsed.Value("walk_seconds_sum", {{"to", "dock"}}), 1002.535);
}

TEST(Exposition, WritesNumbersThatReadBackAsTheyAre) {
  Exposition text(MetricsFormat::kOpenMetrics);
  text.BeginGauge({"a", "A."});
  text.Add(0.1, {{"n", "tenth"}});
  text.Add(-1e300, {{"n", "huge"}});
  text.Add(std::numeric_limits<double>::infinity(), {{"n", "inf"}});
  text.Add(std::uint64_t{18446744073709551615U}, {{"n", "most"}});
  const std::string written = Finish(text);
  EXPECT_THAT(ParseOpenMetrics(written).errors, IsEmpty()) << written;
  EXPECT_THAT(written, HasSubstr("\"tenth\"} 0.1\n"));
  EXPECT_THAT(written, HasSubstr("\"huge\"} -1e+300\n"));
  EXPECT_THAT(written, HasSubstr("\"inf\"} +Inf\n"));
  EXPECT_THAT(written, HasSubstr("\"most\"} 18446744073709551615\n"));
}

TEST(Exposition, ReplacesWhatIsNotUtf8) {
  Exposition text(MetricsFormat::kOpenMetrics);
  text.BeginGauge({"a", "A."});
  text.Add(1.0, {{"x", std::string_view("caf\xC3\xA9 \xF0\x9F\xA4\x96 \xFF\xED\xA0\x80\0!", 17)}});
  const ParsedMetrics parsed = ParseOpenMetrics(Finish(text));
  EXPECT_THAT(parsed.errors, IsEmpty());
  const std::string bad = "\xEF\xBF\xBD";
  EXPECT_EQ(parsed.families.at(0).samples.at(0).labels.at(0).second,
            "café 🤖 " + bad + bad + bad + bad + bad + "!");
}

// The label of a sample that was written with it, as it is read.
std::string ReadBack(std::string_view value) {
  Exposition text(MetricsFormat::kOpenMetrics);
  text.BeginGauge({"a", "A."});
  text.Add(1.0, {{"x", value}});
  const ParsedMetrics parsed = ParseOpenMetrics(Finish(text));
  EXPECT_THAT(parsed.errors, IsEmpty());
  return parsed.families.at(0).samples.at(0).labels.at(0).second;
}

TEST(Exposition, KeepsTheFirstAndTheLastCharacterOfEachLength) {
  for (const char* character :
       {"\x01", "\x7F", "\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80",
        "\xEF\xBF\xBF", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_EQ(ReadBack(character), character);
  }
}

TEST(Exposition, ReplacesEachByteOfWhatIsAlmostACharacter) {
  for (const std::string_view bytes :
       {"\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
        "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\x80", "\xE2\x82", "\xF0\x9F\xA4"}) {
    std::string replaced;
    for (std::size_t i = 0; i < bytes.size(); ++i) replaced += "\xEF\xBF\xBD";
    EXPECT_EQ(ReadBack(bytes), replaced);
  }
}

// std::string of RapidCheck has bytes of ASCII only; these have all, and parts of characters.
rc::Gen<std::string> AnyBytes() {
  const auto byte = rc::gen::map(rc::gen::inRange(0, 256),
                                 [](int b) { return std::string(1, static_cast<char>(b)); });
  const auto part = rc::gen::oneOf(
      byte,
      rc::gen::element<std::string>("\"", "\\", "\n", "\\n", "ü", "🤖", "\xE2\x82", "\r", ","));
  return rc::gen::map(rc::gen::container<std::vector<std::string>>(part),
                      [](const std::vector<std::string>& parts) {
                        std::string all;
                        for (const std::string& one : parts) all += one;
                        return all;
                      });
}

RC_GTEST_PROP(ExpositionProperty, LabelsOfAnyBytesKeepToTheGrammar, ()) {
  const std::string name = *AnyBytes();
  const std::string help = *AnyBytes();
  Exposition text(MetricsFormat::kOpenMetrics);
  text.BeginStateSet({"a", help});
  text.AddStates(std::vector<std::string_view>{"x"}, name, {{"label", name}});
  text.BeginCounter({"b", help});
  text.Add(1.5, {{"label", name}});
  const std::string written = Finish(text);
  const ParsedMetrics parsed = ParseOpenMetrics(written);
  if (!parsed.errors.empty()) RC_FAIL(parsed.errors.front() + "\n" + written);
  // What is UTF-8 comes back unchanged.
  Exposition again(MetricsFormat::kOpenMetrics);
  const std::string& read = parsed.families.at(1).samples.at(0).labels.at(0).second;
  again.BeginCounter({"b", "B."});
  again.Add(1.5, {{"label", read}});
  RC_ASSERT(ParseOpenMetrics(Finish(again)).families.at(0).samples.at(0).labels.at(0).second ==
            read);
}

TEST(MetricsFormat, IsOpenMetricsUnlessTheClientPrefersText) {
  // As Prometheus sends it.
  EXPECT_EQ(FormatFor("application/openmetrics-text;version=1.0.0;q=0.5,"
                      "application/openmetrics-text;version=0.0.1;q=0.4,"
                      "text/plain;version=0.0.4;q=0.3,*/*;q=0.2"),
            MetricsFormat::kOpenMetrics);
  EXPECT_EQ(FormatFor(""), MetricsFormat::kOpenMetrics);
  EXPECT_EQ(FormatFor("*/*"), MetricsFormat::kOpenMetrics);
  EXPECT_EQ(FormatFor("text/plain"), MetricsFormat::kPrometheus);
  EXPECT_EQ(FormatFor("text/plain;version=0.0.4;q=0.5, */*;q=0.1"), MetricsFormat::kPrometheus);
  EXPECT_EQ(FormatFor("application/openmetrics-text;q=0.1, text/plain"),
            MetricsFormat::kPrometheus);
  EXPECT_EQ(FormatFor("text/html,application/xml;q=0.9,*/*;q=0.8"), MetricsFormat::kPrometheus);
  EXPECT_EQ(FormatFor(";;,,q=;"), MetricsFormat::kOpenMetrics);
}

}  // namespace musher::view::exposition_test
