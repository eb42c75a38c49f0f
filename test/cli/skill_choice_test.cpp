#include "musher/cli/machine/skill_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/cli/commands/skill/skill_goal.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli::skill_choice_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const msg::SkillOffer kTakeOff{
    "take_off", "rises", {"altitude: a number, default 1 (m)", "name: a text, required"}};
const std::vector<msg::SkillOffers> kOffers = {
    {"cf2x_0", "/cf2x_0/skill_execution", {kTakeOff, {"land", "", {}}}},
    {"cf2x_1", "/cf2x_1/skill_execution", {kTakeOff}}};

std::string ErrorOf(const std::vector<std::string>& words) {
  const auto parameters = SkillParameters(kTakeOff, words);
  return parameters ? "none" : parameters.error().message;
}

TEST(SkillChoice, TakesTheOnlyActuatorThatOffersTheSkill) {
  EXPECT_EQ(ChooseSkill(kOffers, "land", "").value().actuator, "cf2x_0");
  EXPECT_EQ(ChooseSkill(kOffers, "take_off", "cf2x_1").value().action, "/cf2x_1/skill_execution");
}

TEST(SkillChoice, RequiresTheActuatorWhereSeveralOfferTheSkill) {
  EXPECT_EQ(ChooseSkill(kOffers, "take_off", "").error().message,
            "take_off is offered by cf2x_0, cf2x_1; choose one of them with --actuator NAME");
  EXPECT_EQ(FindSkill(kOffers, "take_off", "").value().size(), 2U);
}

TEST(SkillChoice, SuggestsTheNearestSkill) {
  EXPECT_EQ(ChooseSkill(kOffers, "takeoff", "").error().message,
            "there is no skill 'takeoff'; did you mean 'take_off'? There are land and take_off");
  EXPECT_EQ(ChooseSkill(kOffers, "land", "cf2x_1").error().message,
            "cf2x_1: there is no skill 'land'; there is only take_off");
}

TEST(SkillChoice, ReadsParametersAsTexts) {
  const auto parameters = SkillParameters(kTakeOff, {"altitude=[1, 2]", "name=a = b"});
  ASSERT_TRUE(parameters.ok());
  EXPECT_THAT(parameters.value(), ElementsAre(msg::SkillParameter{"altitude", "[1, 2]"},
                                              msg::SkillParameter{"name", "a = b"}));
}

TEST(SkillChoice, RefusesAWordThatIsNoParameterOfTheSkill) {
  EXPECT_THAT(ErrorOf({"altitud=2"}), HasSubstr("take_off: there is no parameter 'altitud'; did "
                                                "you mean 'altitude'?"));
  EXPECT_EQ(ErrorOf({"altitude"}), "expected KEY=VALUE, found 'altitude'");
  EXPECT_EQ(ErrorOf({"=2"}), "expected KEY=VALUE, found '=2'");
  EXPECT_EQ(ErrorOf({"name=a", "name=b"}), "name is given twice");
  EXPECT_EQ(SkillParameters(kOffers[0].skills[1], {"a=1"}).error().message,
            "land: there is no parameter 'a'; the skill has no parameters");
}

TEST(SkillReport, IsReadFromTheTextOfTheAction) {
  EXPECT_EQ(ReadSkillReport("processing: Moving (3.2 s) (52%)"),
            (SkillReport{"processing", "Moving (3.2 s)", 52}));
  EXPECT_EQ(ReadSkillReport("failed: no path (0%)"), (SkillReport{"failed", "no path", 0}));
  EXPECT_EQ(ReadSkillReport("wait is running already"),
            (SkillReport{"", "wait is running already", 0}));
  EXPECT_EQ(ReadSkillReport("completed: (%)"), (SkillReport{"completed", "(%)", 0}));
  EXPECT_EQ(ReadSkillReport("completed: x (99999999999%)").message, "x (99999999999%)");
  EXPECT_EQ(ReadSkillReport(""), SkillReport{});
}

TEST(SkillReport, FitsOnALineOfATerminal) {
  const SkillReport report{"processing", "Planning the path", 20};
  EXPECT_EQ(SkillProgressText("navigate_to", report, 3, false),
            "navigate_to  [####................]   20 %  Planning the path  3 s");
  const SkillReport wordy{"processing", std::string(500, 'x') + "\n", 100};
  EXPECT_LT(Width(SkillProgressText(std::string(300, 'y'), wordy, 100000, false)), 80U);
}

TEST(SkillGoal, HasAnIdOf32HexadecimalDigits) {
  const transport::GoalId id{1, 2, 0xab, 255};
  EXPECT_EQ(GoalIdText(id), "0102abff000000000000000000000000");
  EXPECT_EQ(ReadGoalId(GoalIdText(id)), id);
  EXPECT_FALSE(ReadGoalId("0102abff"));
  EXPECT_FALSE(ReadGoalId("0102abff0000000000000000000000-1"));
  EXPECT_FALSE(ReadGoalId("0102abff0000000000000000000000zz"));
}

SkillEnd EndOf(transport::GoalEnd how, const std::string& text, bool accepted = true) {
  SkillEnd end{"land", "cf2x_0", SkillOutcome::kRunning, "", 30, 2, ""};
  FillSkillEnd({how, {how == transport::GoalEnd::kSucceeded, text}, "its reason"}, accepted, end);
  return end;
}

TEST(SkillGoal, EndsAsItsActuatorReports) {
  using transport::GoalEnd;
  EXPECT_EQ(SkillEndText(EndOf(GoalEnd::kSucceeded, "completed: Landed (100%)")),
            "land of cf2x_0 completed in 2.0 s: Landed");
  EXPECT_EQ(SkillEndText(EndOf(GoalEnd::kAborted, "failed: too windy (30%)")),
            "land of cf2x_0 failed after 2.0 s: too windy");
  EXPECT_EQ(SkillEndText(EndOf(GoalEnd::kAborted, "cancelled: the robot goes to OTA (30%)")),
            "land of cf2x_0 was cancelled after 2.0 s: the robot goes to OTA");
  EXPECT_EQ(SkillEndText(EndOf(GoalEnd::kAborted, "land is running already")),
            "land of cf2x_0 was refused: land is running already");
  EXPECT_EQ(SkillEndText(EndOf(GoalEnd::kLost, "")),
            "land of cf2x_0 is lost after 2.0 s: its reason");
  EXPECT_EQ(SkillEndText(EndOf(GoalEnd::kLost, "", false)),
            "land of cf2x_0 has not started: its reason");
  EXPECT_EQ(EndOf(GoalEnd::kLost, "").progress, 30);
}

}  // namespace musher::cli::skill_choice_test
