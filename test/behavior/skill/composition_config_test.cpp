// Compositions of a config file.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/manager.hpp"
#include "musher/behavior/skill/toml/skills_toml.hpp"
#include "musher/behavior/skill/wait.hpp"
#include "musher/test/behavior/skill/skills.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::skill::composition_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Script;
using testing::Scripted;

class Compositions : public ::testing::Test {
 protected:
  Compositions() {
    EXPECT_TRUE(registry_.Add<Scripted>("walk", walk_));
    EXPECT_TRUE(registry_.Add("wait", Wait()));
    EXPECT_TRUE(registry_.Add("take_off", [] {
      return std::make_unique<StepFunction>(
          [](Table& table) {
            table.Takes("altitude", 1.0, "m");
            table.To(table.State("EXECUTING"), kSucceeded, "up");
          },
          [](Tick& tick) { return Next::Succeed(ToText(tick.parameters.Number("altitude"))); });
    }));
    walk_.step = testing::CompletesAfter(3);
  }
  Parsed<Config> Reading(const std::string& text) {
    return ReadConfig(text, "skills.toml", registry_);
  }
  std::vector<std::string> ErrorsOf(const std::string& text) {
    const Parsed<Config> reading = Reading(text);
    EXPECT_FALSE(reading.config);
    return musher::testing::Lines(reading.diagnostics);
  }
  void Configure(const std::string& text) {
    const Parsed<Config> reading = Reading(text);
    ASSERT_THAT(reading.diagnostics, IsEmpty());
    const Result<> configured = registry_.Configure(*reading.config);
    ASSERT_TRUE(configured.ok()) << configured.error().message;
  }

  Script walk_;
  Registry registry_;
};

TEST_F(Compositions, RunTheirSkillsAndThoseOfOthersInside) {
  const Parsed<Config> reading =
      ReadConfigFile(SourceDir() + "/test/behavior/skill/survey.toml", registry_);
  ASSERT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(registry_.Configure(*reading.config));
  EXPECT_EQ(registry_.Of(*reading.config, "cf2x").value().front().name, "survey");
  EXPECT_EQ(registry_.Find("survey")->settings.run, std::chrono::seconds(60));

  Manager manager(registry_.All());
  ASSERT_TRUE(manager.Start("survey"));
  const skill::Run& run = *manager.Find("survey");
  std::vector<std::string> states;
  Time now;
  for (int i = 0; i < 100 && run.running(); ++i) {
    manager.RunOnce(now += Milliseconds(100));
    if (states.empty() || states.back() != run.Path()) states.push_back(run.Path());
  }
  EXPECT_EQ(run.feedback().status, Status::kCompleted);
  EXPECT_NEAR(ToSeconds(run.now()), 5.5, 0.4);  // 2 s and 3 s
  EXPECT_EQ(run.inside()[0]->feedback().message, "2");
  EXPECT_EQ(run.inside()[1]->inside()[0]->parameters().Number("speed"), 0.2);
  EXPECT_THAT(states,
              ::testing::IsSupersetOf(
                  {"RUNNING/look/RUNNING/[walk/EXECUTING, wait/WAITING]", "RUNNING/wait/WAITING"}));
}

TEST_F(Compositions, MayStandBeforeThoseThatTheyRun) {
  const Parsed<Config> reading = Reading(R"([skill.a]
in_order = [{ skill = "b" }]
[skill.b]
first_to_finish = [{ skill = "c" }, { skill = "wait" }]
[skill.c]
in_order = [{ skill = "take_off" }, { skill = "take_off", altitude = 3 }]
)");
  ASSERT_TRUE(reading.config);
  std::vector<std::string> names;
  for (const auto& composition : reading.config->compositions) names.push_back(composition.name);
  EXPECT_THAT(names, ElementsAre("c", "b", "a"));
  EXPECT_EQ(reading.config->compositions[1].order, Order::kFirstToFinish);
  EXPECT_TRUE(registry_.Configure(*reading.config));
}

TEST_F(Compositions, HaveTheSettingsOfTheirParts) {
  Configure(R"([skill.patrol]
in_order = [{ skill = "take_off" }]
[skill.take_off]
parameters = { altitude = 4 }
)");
  const skill::Run run("patrol", registry_.Find("patrol")->make());
  EXPECT_EQ(run.table().parameters()[0].name, "take_off.altitude");
  EXPECT_EQ(run.table().parameters()[0].otherwise, Value(4.0));
}

TEST_F(Compositions, AreRefusedWithEveryErrorAndItsPlace) {
  EXPECT_THAT(
      ErrorsOf(R"([skill.a]
in_order = [{ skill = "wiat" }, { skill = "take_off", altitud = 2 }, { altitude = 1 }]
[skill.b]
parallel = [{ skill = "take_off", altitude = "high" }, "wait", { skill = 3 }]
[skill.c]
in_order = []
[skill.d]
in_order = "wait"
[skill.e]
in_order = [{ skill = "wait" }]
parallel = [{ skill = "wait" }]
[skill.f]
in_order = [{ skill = "wait" }]
retrys = 3
parameters = { "wait.duration" = 3 }
[skill.wait]
in_order = [{ skill = "take_off" }]
)"),
      ElementsAre(
          HasSubstr("skills.toml:2:23: error: skill.a.in_order[0]: there is no skill \"wiat\"; "
                    "did you mean \"wait\"?"),
          HasSubstr("skills.toml:2:55: error: skill.a.in_order[1]: there is no parameter "
                    "\"altitud\"; did you mean \"altitude\"?"),
          HasSubstr("skills.toml:2:70: error: skill.a.in_order[2]: the key \"skill\" is missing"),
          HasSubstr("skills.toml:4:46: error: skill.b.parallel[0].altitude: expected a number"),
          HasSubstr("skills.toml:4:56: error: skill.b.parallel[1]: expected a table"),
          HasSubstr("skills.toml:4:74: error: skill.b.parallel[2].skill: expected a string"),
          HasSubstr("skills.toml:6:12: error: skill.c.in_order: expected a list of tables"),
          HasSubstr("skills.toml:8:12: error: skill.d.in_order: expected a list of tables"),
          HasSubstr("skills.toml:11:12: error: skill.e.parallel: it has in_order already"),
          HasSubstr("skills.toml:14:1: error: skill.f: unknown key \"retrys\""),
          HasSubstr("skills.toml:15:16: error: skill.f.parameters: there is no parameter "
                    "\"wait.duration\"; did you mean \"wait.duration_s\"?"),
          HasSubstr("skills.toml:16:8: error: skill.wait: a skill of the robot has this name")));
}

TEST_F(Compositions, RefuseToRunThemselves) {
  EXPECT_THAT(ErrorsOf("[skill.a]\nin_order = [{ skill = \"a\" }]\n"),
              ElementsAre("skills.toml:2:23: error: skill.a.in_order[0]: a runs itself: a → a"));
  EXPECT_THAT(
      ErrorsOf(R"([skill.a]
in_order = [{ skill = "wait" }, { skill = "b" }]
[skill.b]
parallel = [{ skill = "c" }]
[skill.c]
in_order = [{ skill = "b" }]
[skill.d]
in_order = [{ skill = "a" }]
)"),
      ElementsAre("skills.toml:6:23: error: skill.c.in_order[0]: b runs itself: b → c → b"));
}

TEST_F(Compositions, RefuseASkillThatWouldRunTwiceAtOnce) {
  EXPECT_THAT(ErrorsOf("[skill.a]\nparallel = [{ skill = \"wait\" }, { skill = \"wait\" }]\n"),
              ElementsAre(HasSubstr(
                  "skills.toml:2:12: error: skill.a.parallel: a: wait would run twice at once")));
}

// Each level has twice the skills of the one below: a short file, and a million skills.
TEST_F(Compositions, AreLimitedInSizeAndDepth) {
  std::string doubled = "[skill.s0]\nin_order = [{ skill = \"wait\" }]\n";
  std::string nested = doubled;
  for (int i = 1; i < 40; ++i) {
    const std::string below = "{ skill = \"s" + std::to_string(i - 1) + "\" }";
    const std::string name = "[skill.s" + std::to_string(i) + "]\nin_order = [";
    doubled += name + below + ", " + below + "]\n";
    nested.insert(0, name + below + "]\n");
  }
  EXPECT_THAT(ErrorsOf(doubled),
              ElementsAre(HasSubstr("skill.s7.in_order: it has 383 skills, with those inside")));
  EXPECT_THAT(ErrorsOf(nested),
              ElementsAre(HasSubstr("more than 32 compositions are inside of each other")));
}

TEST_F(Compositions, OfAnotherConfigAreNotAddedTwice) {
  const std::string text = "[skill.a]\nin_order = [{ skill = \"wait\" }]\n";
  const Parsed<Config> reading = Reading(text);
  ASSERT_TRUE(registry_.Configure(*reading.config));
  const Result<> again = registry_.Configure(*reading.config);
  ASSERT_FALSE(again.ok());
  EXPECT_THAT(again.error().message, HasSubstr("skill a is registered already"));
  EXPECT_EQ(registry_.All().size(), 4U);
}

// A config that a program made, not a file.
TEST_F(Compositions, ChangeNothingWhenOneIsRefused) {
  Config config;
  config.settings = {{"take_off", {.retries = 1}}};
  config.compositions = {{"good", Order::kInOrder, {{"wait"}}}, {"bad", Order::kInOrder, {{"x"}}}};
  const Result<> configured = registry_.Configure(config);
  ASSERT_FALSE(configured.ok());
  EXPECT_THAT(configured.error().message, HasSubstr("bad: there is no skill 'x'"));
  EXPECT_EQ(registry_.Find("good"), nullptr);
  EXPECT_FALSE(registry_.Find("take_off")->settings.retries);
}

}  // namespace musher::skill::composition_config_test
