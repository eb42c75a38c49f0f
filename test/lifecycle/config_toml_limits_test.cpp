// Invalid files: unreadable, of another format, huge, or made to overload the parser.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::config_toml_limits_test {

using ::testing::HasSubstr;

constexpr auto kStates = R"(["SetUp", "TearDown", "SelfCheck", "Active"])";

std::string Controller(const std::string& actuators) {
  return "[controller]\nactuators = [" + actuators + "]\nstates = " + kStates +
         "\ndefault_time = 250\ndefault_state = \"Uninitialized\"\n";
}

std::string Table(const std::string& name, const std::string& keys = "") {
  return "[actuator." + name + "]\nstates = " + kStates +
         "\ntimes = [1, 2, 3, 4]\ncritical = true\n" + keys;
}

std::string Repeat(int count, const std::function<std::string(std::string)>& make) {
  std::string text;
  for (int i = 0; i < count; ++i) text += make(std::to_string(i));
  return text;
}

// The only diagnostic, printed.
std::string OnlyFault(std::string_view text) {
  const ConfigReading reading = ReadConfigText(text, "f");
  EXPECT_FALSE(reading.config);
  EXPECT_EQ(reading.diagnostics.size(), 1U);
  return reading.diagnostics.empty() ? "" : FormatDiagnostic(reading.diagnostics.front());
}

TEST(ConfigTomlLimits, ReportsAMissingFile) {
  const ConfigReading reading = ReadConfigFile("/nowhere/at/all.toml");
  ASSERT_EQ(reading.diagnostics.size(), 1U);
  EXPECT_EQ(FormatDiagnostic(reading.diagnostics[0]),
            "/nowhere/at/all.toml: error: the file cannot be read: No such file or directory");
}

TEST(ConfigTomlLimits, ReportsThatAFolderIsNotAFile) {
  const ConfigReading reading = ReadConfigFile(::testing::TempDir());
  ASSERT_EQ(reading.diagnostics.size(), 1U);
  EXPECT_THAT(reading.diagnostics[0].message, HasSubstr("it is a folder"));
}

TEST(ConfigTomlLimits, StopsReadingAFileThatNeverEnds) {
  const ConfigReading reading = ReadConfigFile("/dev/zero");
  ASSERT_EQ(reading.diagnostics.size(), 1U);
  EXPECT_THAT(reading.diagnostics[0].message, HasSubstr("at most 8 MiB"));
}

TEST(ConfigTomlLimits, PointsAtTheFirstByteThatIsNotUtf8) {
  EXPECT_EQ(OnlyFault("[controller]\nname = \"\xC3\xBC\xFFx\"\n"),
            "f:2:11: error: expected UTF-8, found the byte 0xFF");
  EXPECT_EQ(OnlyFault("a = \"\xC3"), "f:1:6: error: expected UTF-8, found the byte 0xC3");
  EXPECT_EQ(OnlyFault("# \xED\xA0\x80"), "f:1:3: error: expected UTF-8, found the byte 0xED");
  EXPECT_EQ(OnlyFault("# \xC0\x80"), "f:1:3: error: expected UTF-8, found the byte 0xC0");
}

TEST(ConfigTomlLimits, RefusesNulBytes) {
  using std::string_view_literals::operator""sv;
  EXPECT_THAT(OnlyFault("[controller]\nname = \0\n"sv), HasSubstr("f:2:8: error: not TOML"));
}

TEST(ConfigTomlLimits, GivesNoMoreThanTheFirst200DiagnosticsAndCountsTheRest) {
  const ConfigReading reading = ReadConfigText(
      Controller("\"a\"") + Table("a") + Repeat(500, [](auto i) { return "k" + i + " = 1\n"; }),
      "f");
  ASSERT_EQ(reading.diagnostics.size(), 201U);
  EXPECT_THAT(FormatDiagnostic(reading.diagnostics[0]), HasSubstr("f:10:1: error: actuator.a: "));
  EXPECT_EQ(FormatDiagnostic(reading.diagnostics[200]), "f: error: 300 more errors");
}

TEST(ConfigTomlLimits, DropsWarningsBeforeErrors) {
  const ConfigReading reading = ReadConfigText(
      Controller(Repeat(300, [](auto i) { return "\"a" + i + "\","; })) +
          Repeat(300, [](auto i) { return Table("a" + i, "cwd = \"/\"\n"); }) + "oops = 1",
      "f");
  EXPECT_FALSE(reading.config);
  ASSERT_EQ(reading.diagnostics.size(), 201U);
  EXPECT_THAT(FormatDiagnostic(reading.diagnostics[199]), HasSubstr("unknown key \"oops\""));
  EXPECT_EQ(FormatDiagnostic(reading.diagnostics[200]), "f: warning: 101 more warnings");
}

TEST(ConfigTomlLimits, RefusesMoreThan4096ActuatorsInOneSentence) {
  const auto machine = [](int count) {
    return Controller(Repeat(count, [](auto i) { return "\"a" + i + "\","; })) +
           Repeat(count, [](auto i) { return Table("a" + i); });
  };
  EXPECT_TRUE(ReadConfigText(machine(4096), "f").config);
  EXPECT_EQ(OnlyFault(machine(4097)),
            "f:2:13: error: controller.actuators: expected at most 4096 actuators, found 4097");
}

TEST(ConfigTomlLimits, RefusesMoreThan64States) {
  const std::string states = Repeat(65, [](auto i) { return "\"s" + i + "\","; });
  const std::string text = "[controller]\nactuators = [\"a\"]\nstates = [" + states +
                           "]\ndefault_time = 1\ndefault_state = \"Uninitialized\"\n" + Table("a");
  EXPECT_EQ(OnlyFault(text),
            "f:3:10: error: controller.states: expected at most 64 states, found 65");
}

// Each would take minutes, or overflow the stack, without a limit.
struct Attack {
  const char* name;
  std::string (*text)();  // made when its test runs
};

class ConfigTomlAttack : public ::testing::TestWithParam<Attack> {};

TEST_P(ConfigTomlAttack, IsRefusedInTime) {
  const std::string text = GetParam().text();
  const std::clock_t begun = std::clock();  // CPU time: other programs do not count
  EXPECT_FALSE(ReadConfigText(text, "f").config);
  // Well under half a second without sanitizers; the bound only has to distinguish that from
  // minutes.
  EXPECT_LT((std::clock() - begun) / CLOCKS_PER_SEC, 10);
}

std::string ManyNames() {
  return Repeat(10'000, [](auto i) { return "\"act_" + i + "\","; });
}

std::vector<Attack> Attacks() {
  return {
      {"TooLarge", [] { return std::string(10 << 20, '#'); }},
      {"DeepArray", [] { return "a = " + std::string(1'000'000, '['); }},
      {"DeepKey", [] { return Repeat(1'000'000, [](auto) { return "a."; }) + "a = 1"; }},
      {"DeepHeader", [] { return "[" + Repeat(1'000'000, [](auto) { return "a."; }) + "a]"; }},
      {"DeepQuotedKey", [] { return Repeat(1'000'000, [](auto) { return "\"=\"."; }) + "a = 1"; }},
      {"ManyDottedKeys",
       [] {
         return Repeat(300'000, [](auto i) { return "k" + i + ".a = 1\n"; }) +
                Repeat(300'000, [](auto i) { return "k" + i + ".b = 1\n"; });
       }},
      {"ManyTables", [] { return Repeat(700'000, [](auto) { return "[[a]]\n"; }); }},
      {"ManyUnknownKeys",
       [] {
         return Controller("\"a\"") + Repeat(100'000, [](auto i) { return "key" + i + " = 1\n"; });
       }},
      {"AllNamesWithoutTable", [] { return Controller(ManyNames()); }},
      {"AllNamesMisspelt",
       [] {
         return Controller(Repeat(10'000, [](auto i) { return "\"akt_" + i + "\","; })) +
                Repeat(10'000, [](auto i) { return Table("act_" + i); });
       }},
      {"OneRing",
       [] {
         return Controller(ManyNames()) + Repeat(10'000, [](auto i) {
                  const int next = (std::stoi(i) + 1) % 10'000;
                  return Table("act_" + i, "after = [\"act_" + std::to_string(next) + "\"]\n");
                });
       }},
      {"OneLongLine",
       [] {
         return Controller("\"a\"") + "x = [" +
                Repeat(400'000, [](auto i) { return "\"\xC3\xA9" + i + "\","; }) + "]";
       }},
  };
}

INSTANTIATE_TEST_SUITE_P(, ConfigTomlAttack, ::testing::ValuesIn(Attacks()),
                         [](const auto& test) { return test.param.name; });

}  // namespace musher::config_toml_limits_test
