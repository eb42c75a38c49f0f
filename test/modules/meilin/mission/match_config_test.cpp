// The config of a match and of the mission: what is wrong, and where.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "musher/modules/meilin/mission/match_config.hpp"
#include "musher/modules/meilin/mission/mission_config.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::meilin::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

std::string ConfigText(const std::string& name) {
  std::ifstream file(SourceDir() + "/config/meilin/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}
std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

TEST(MeilinMatchConfig, HasTheValuesOfBothSides) {
  const MatchReading blue = ReadMatchText(ConfigText("match_blue.json"), "m.json");
  const MatchReading red = ReadMatchText(ConfigText("match_red.json"), "m.json");
  ASSERT_TRUE(blue.config && red.config);
  EXPECT_EQ(blue.config->side, Side::kBlue);
  EXPECT_THAT(blue.config->entries, Contains(Pair("prepare_align_target_y", -0.30)));
  EXPECT_THAT(blue.config->entries, Contains(Pair("final_final_move2_target_yaw", 4.71)));
  EXPECT_THAT(red.config->entries, Contains(Pair("prepare_align_target_y", 0.30)));
  EXPECT_THAT(red.config->entries, Contains(Pair("final_finish_suspension_height", 30)));
}
TEST(MeilinMatchConfig, NamesAMissingSectionByItsPath) {
  const std::string text = Replaced(ConfigText("match_blue.json"), "\"dock\"", "\"dok\"");
  EXPECT_THAT(ReadMatchText(text, "m.json").errors,
              ElementsAre("m.json: prepare.dok: unknown key; did you mean 'dock'?",
                          "m.json: prepare.dock: missing; expected an object with timeout_sec"));
}
TEST(MeilinMatchConfig, NamesAWrongValue) {
  const std::string text =
      Replaced(ConfigText("match_blue.json"), "\"target_x\": 0.5", "\"target_x\": \"near\"");
  EXPECT_THAT(
      ReadMatchText(text, "m.json").errors,
      ElementsAre("m.json: prepare.spear_prep.target_x: expected a number, found \"near\""));
}
TEST(MeilinMatchConfig, RefusesWhatIsNoJson) {
  EXPECT_EQ(ReadMatchText("{", "m.json").errors.size(), 1U);
  EXPECT_THAT(ReadMatchText("[]", "m.json").errors, ElementsAre(HasSubstr("expected an object")));
}
TEST(MeilinMatchConfig, RefusesATextThatIsNestedTooDeeply) {
  for (const char* piece : {"[", "{\"a\":"}) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += piece;
    EXPECT_THAT(ReadMatchText(text, "m.json").errors,
                ElementsAre(HasSubstr("nested deeper than 32 levels")));
  }
}
TEST(MeilinMatchConfig, RefusesWhatTheRobotCannotReach) {
  const std::string good = ConfigText("match_blue.json");
  for (const auto& [from, to] :
       {std::pair("\"target_x\": 0.5", "\"target_x\": 1e300"),
        std::pair("\"target_yaw\": 3.14", "\"target_yaw\": 99"),
        std::pair("\"suspension_height\": 30", "\"suspension_height\": 999"),
        std::pair("\"max_speed\": 0.3", "\"max_speed\": 1e9")}) {
    const MatchReading reading = ReadMatchText(Replaced(good, from, to), "m.json");
    EXPECT_FALSE(reading.config) << to;
    EXPECT_EQ(reading.errors.size(), 1U) << to;
  }
}
TEST(MeilinMissionConfig, TheFileIsRight) {
  const Parsed<MissionConfig> reading = ReadMissionText(ConfigText("mission.toml"), "mission.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->settings.grid.origin.x_m, 1.2);
}
TEST(MeilinMissionConfig, NamesWhatIsWrong) {
  const Parsed<MissionConfig> reading = ReadMissionText(
      "tree_file = \"a.xml\"\nmeilin_grid_origin = [1]\nmeilin_side = \"green\"\nmeilin_yaw = 1\n",
      "m.toml");
  EXPECT_FALSE(reading.config);
  ASSERT_EQ(reading.diagnostics.size(), 3U);
  EXPECT_EQ(reading.diagnostics[0].line, 2);
  EXPECT_THAT(reading.diagnostics[0].message, HasSubstr("expected two numbers"));
}

}  // namespace
}  // namespace musher::meilin::testing
