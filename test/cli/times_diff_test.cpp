// The proposed limits as a change of the config, which `patch` takes.

#include "musher/cli/config/times_diff.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "musher/base/files.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::times_diff_test {

using ::testing::HasSubstr;

constexpr const char* kController = R"([controller]
actuators = ["legs", "lamp"]
states = ["SetUp", "TearDown", "SelfCheck", "Active"]
default_time = 1000
default_state = "Uninitialized"

)";
constexpr const char* kLegs = R"([actuator.legs]
states = ["SetUp", "TearDown", "SelfCheck", "Active"]
times = [
  8_000,  # a slow board
  1000,
  2000, 5000,  # the last one walks
]
# a comment
stage = 1
# another one
)";
// Its limits are behind characters of two bytes each.
constexpr const char* kLamp =
    "[actuator]\n"
    "lamp = { cwd = \"/é/ü\", command = [\"lamp\"], states = [\"SetUp\", \"TearDown\", "
    "\"SelfCheck\", \"Active\"], times = [1000, 1000, 1000, 1000] }";

LearnedTime Proposal(const std::string& actuator, const char* state, double ms) {
  LearnedTime row;
  row.actuator = actuator;
  row.state = State(state);
  row.proposed_ms = ms;
  return row;
}

std::string DiffOf(const std::string& text, const std::vector<LearnedTime>& learned,
                   const std::string& name = "robot.toml") {
  const ConfigReading read = ReadConfigText(text, name);
  if (!read.config) {
    for (const Diagnostic& one : read.diagnostics) ADD_FAILURE() << FormatDiagnostic(one);
    return "";
  }
  const auto diff = TimesDiff(text, *read.config, learned, name);
  return diff ? diff.value() : "error: " + diff.error().message;
}

std::string Replaced(std::string text, const std::string& before, const std::string& after) {
  for (std::size_t at = 0; (at = text.find(before, at)) != std::string::npos; at += after.size()) {
    text.replace(at, before.size(), after);
  }
  return text;
}

const std::vector<LearnedTime>& ThreeProposals() {
  static const std::vector<LearnedTime> rows = {Proposal("lamp", "TearDown", 300),
                                                Proposal("legs", "SetUp", 9000),
                                                Proposal("legs", "Active", 600)};
  return rows;
}

// The tables of both in one text: an inline table cannot follow [actuator.legs].
std::string Robot() {
  return std::string(kController) + "[actuator]\n" + Replaced(kLamp, "[actuator]\n", "") + "\n\n" +
         kLegs;
}

TEST(TimesDiff, ChangesOnlyTheNumbersOfAnArrayOverSeveralLines) {
  EXPECT_EQ(DiffOf(Robot(), ThreeProposals()),
            "--- robot.toml\n"
            "+++ robot.toml\n"
            "@@ -5,14 +5,14 @@\n"
            " default_state = \"Uninitialized\"\n"
            " \n"
            " [actuator]\n"
            "-lamp = { cwd = \"/é/ü\", command = [\"lamp\"], states = [\"SetUp\", \"TearDown\", "
            "\"SelfCheck\", \"Active\"], times = [1000, 1000, 1000, 1000] }\n"
            "+lamp = { cwd = \"/é/ü\", command = [\"lamp\"], states = [\"SetUp\", \"TearDown\", "
            "\"SelfCheck\", \"Active\"], times = [1000, 300, 1000, 1000] }\n"
            " \n"
            " [actuator.legs]\n"
            " states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\"]\n"
            " times = [\n"
            "-  8_000,  # a slow board\n"
            "+  9000,  # a slow board\n"
            "   1000,\n"
            "-  2000, 5000,  # the last one walks\n"
            "+  2000, 600,  # the last one walks\n"
            " ]\n"
            " # a comment\n"
            " stage = 1\n");
}

TEST(TimesDiff, IsEmptyWhereNoLimitIsToBeChanged) {
  EXPECT_EQ(DiffOf(Robot(), {}), "");
  LearnedTime row = Proposal("legs", "Active", 1);
  row.proposed_ms.reset();
  EXPECT_EQ(DiffOf(Robot(), {row, Proposal("arm", "Active", 600)}), "");
}

TEST(TimesDiff, RefusesANumberThatIsNotDecimal) {
  EXPECT_THAT(DiffOf(Replaced(Robot(), "5000", "0x1388"), ThreeProposals()),
              HasSubstr("error: robot.toml:15: the limit 5000 is not written as a decimal number"));
}

class Patching : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v patch >/dev/null") != 0) GTEST_SKIP() << "no patch here";
  }
  // The text after `patch -p0` with its diff, in a file of this name.
  std::string Patched(const std::string& text, const std::string& name = "robot.toml") const {
    const std::string diff = DiffOf(text, ThreeProposals(), name);
    std::ofstream(folder_ / name, std::ios::binary) << text;
    std::ofstream(folder_ / "limits.diff", std::ios::binary) << diff;
    const std::string command = "cd " + folder_.path() + " && patch -p0 --fuzz=0 -s <limits.diff";
    EXPECT_EQ(std::system(command.c_str()), 0) << diff;
    return ReadFile(folder_ / name);
  }
  static std::string Expected(const std::string& text) {
    std::string changed = Replaced(Replaced(text, "8_000", "9000"), "5000", "600");
    return Replaced(changed, "[1000, 1000,", "[1000, 300,");
  }

  TempFolder folder_;
};

TEST_F(Patching, GivesTheLimits) {
  EXPECT_EQ(Patched(Robot()), Expected(Robot()));
  const std::string text = Patched(Robot(), "my robot.toml");
  const auto config = ReadConfigText(text, "robot.toml").config;
  ASSERT_TRUE(config);
  EXPECT_EQ(config->actuators[*config->IndexOf("legs")].TimeFor("Active"), Milliseconds(600));
}

TEST_F(Patching, WorksAlsoWithoutALastLineEnd) {
  std::string text = Robot();
  text.resize(text.find(",  # the last one walks"));
  text += "]";
  EXPECT_EQ(Patched(text), Expected(text));
}

TEST_F(Patching, WorksAlsoWithLinesOfWindowsAndAByteOrderMark) {
  const std::string text = "\xef\xbb\xbf" + Replaced(Robot(), "\n", "\r\n");
  EXPECT_EQ(Patched(text), Expected(text));
}

// Changes that are far from each other have a hunk each.
TEST_F(Patching, WorksWithSeveralHunks) {
  std::string many_lines;
  for (int i = 0; i < 7; ++i) many_lines += "# a line\n";
  for (const int lines : {5, 6, 7}) {
    const std::string between = many_lines.substr(0, static_cast<std::size_t>(lines) * 9);
    const std::string text = Replaced(Robot(), "[actuator.legs]", between + "[actuator.legs]");
    EXPECT_EQ(Patched(text), Expected(text)) << lines;
  }
}

}  // namespace musher::cli::times_diff_test
