#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/toml/skills_toml.hpp"
#include "musher/behavior/skill/wait.hpp"
#include "musher/test/behavior/skill/skills.hpp"
#include "musher/test/support/diagnostics.hpp"

namespace musher::skill::config_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::Script;
using testing::Scripted;

class AConfig : public ::testing::Test {
 protected:
  AConfig() {
    EXPECT_TRUE(registry_.Add<Scripted>("walk", script_));
    EXPECT_TRUE(registry_.Add("wait", Wait()));
  }
  std::vector<std::string> ErrorsOf(const std::string& text) {
    return musher::testing::Lines(ReadConfig(text, "skills.toml", registry_).diagnostics);
  }

  Script script_;
  Registry registry_;
};

TEST_F(AConfig, HasTheSkillsOfRobotsAndTheirSettings) {
  const Parsed<Config> reading = ReadConfig(R"([group.base]
skills = ["wait"]

[group.ground]
robots = ["jetbot", "h1"]
skills = ["walk", "wait"]

[skill.walk]
time_limit_ms = 40000
cancel_limit_ms = 0
retries = 0
state_limits_ms = { EXECUTING = 30000, INITIALIZING = 0 }
parameters = { speed = 1, goal = [1, 2.5] }
)",
                                            "skills.toml", registry_);
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(reading.config->groups[1],
            (Config::Group{"ground", {"jetbot", "h1"}, {"walk", "wait"}}));
  ASSERT_TRUE(registry_.Configure(*reading.config));
  const Settings& walk = registry_.Find("walk")->settings;
  EXPECT_EQ(walk.run, std::chrono::seconds(40));
  EXPECT_EQ(walk.cancel, kNoLimit);
  EXPECT_EQ(walk.retries, 0);
  EXPECT_EQ(walk.states[0],
            (std::pair<std::string, Duration>("EXECUTING", std::chrono::seconds(30))));
  EXPECT_EQ(walk.states[1].second, kNoLimit);
  EXPECT_EQ(walk.parameters.Number("speed"), 1.0);
  EXPECT_EQ(registry_.Of(*reading.config, "h1").value().size(), 2U);
}

TEST_F(AConfig, IsRefusedWithEveryErrorItsPlaceAndTheNearestName) {
  EXPECT_THAT(
      ErrorsOf(R"([group.ground]
robots = ["h1"]
skills = ["wlak", "wait"]
[skill.wiat]
[skill.walk]
retrys = 3
retries = -1
time_limit_ms = "long"
state_limits_ms = { EXECUTNG = 1, FAILED = 2 }
parameters = { sped = 1, speed = "fast", goal = ["a"] }
[group.none]
)"),
      ElementsAre(
          "skills.toml:3:11: error: group.ground.skills: there is no skill \"wlak\"; did you mean "
          "\"walk\"?",
          "skills.toml:4:8: error: skill: there is no skill \"wiat\"; did you mean \"wait\"?",
          ::testing::HasSubstr("skills.toml:6:1: error: skill.walk: unknown key \"retrys\""),
          ::testing::HasSubstr("skills.toml:7:11: error: skill.walk.retries"),
          ::testing::HasSubstr("skills.toml:8:17: error: skill.walk.time_limit_ms"),
          "skills.toml:9:21: error: skill.walk.state_limits_ms: there is no state \"EXECUTNG\"; "
          "did "
          "you mean \"EXECUTING\"?",
          "skills.toml:9:35: error: skill.walk.state_limits_ms: there is no state \"FAILED\"",
          "skills.toml:10:16: error: skill.walk.parameters: there is no parameter \"sped\"; did "
          "you "
          "mean \"speed\"?",
          "skills.toml:10:34: error: skill.walk.parameters.speed: expected a number",
          "skills.toml:10:49: error: skill.walk.parameters.goal: expected a list of numbers",
          ::testing::HasSubstr(
              "skills.toml:11:8: error: group.none: the key \"skills\" is missing")));
}

TEST_F(AConfig, IsRefusedAtItsFirstSyntaxError) {
  EXPECT_THAT(ErrorsOf("[group"), ::testing::SizeIs(1));
  EXPECT_FALSE(ReadConfigFile("/nowhere/skills.toml", registry_).config);
}

}  // namespace musher::skill::config_test
