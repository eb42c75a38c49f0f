// The messages about skills, without a process.

#include "musher/application/skill_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/wait.hpp"

namespace musher::skill_report_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ASkillReport : public ::testing::Test {
 protected:
  static skill::Registry Skills() {
    skill::Registry registry;
    EXPECT_TRUE(registry.Add("wait", skill::Wait()));
    EXPECT_TRUE(registry.Add(
        "twice", skill::Compose(skill::Order::kInOrder, registry, {{"wait"}, {"wait"}})));
    return registry;
  }
  msg::GetSkill::Response Get(const std::string& skill, const std::string& format = "") {
    msg::GetSkill::Request request;
    request.skill = skill;
    request.format = format;
    return ReportSkill("robot_0", manager_, true, request);
  }

  skill::Manager manager_{Skills().All()};
};

TEST_F(ASkillReport, OffersEachSkillWithWhatItDoesAndItsParameters) {
  const msg::SkillOffers offers = OfferSkills("robot_0", "/robot_0/skill_execution", manager_);
  EXPECT_EQ(offers.actuator, "robot_0");
  EXPECT_EQ(offers.action, "/robot_0/skill_execution");
  ASSERT_EQ(offers.skills.size(), 2U);
  EXPECT_EQ(offers.skills[0].skill, "wait");
  EXPECT_EQ(offers.skills[0].summary, "Waits for a time");
  EXPECT_THAT(offers.skills[0].parameters,
              ElementsAre("duration_s: a number, default 1 (seconds, 0 or more)",
                          "timeout: a number, default none (s; a run that takes longer fails)"));
  EXPECT_THAT(offers.skills[1].parameters, ::testing::Contains(HasSubstr("timeout: a number, ")));
  EXPECT_EQ(offers.skills[1].summary, "Runs wait, then wait");
}

TEST_F(ASkillReport, HasTheRunWithItsHistoryErrorsAndPicture) {
  ASSERT_TRUE(manager_.Start("wait", {{"duration_s", 4.0}}, {"ab12", "alice@desk"}));
  manager_.RunOnce(Time{});
  manager_.RunOnce(Time{} + std::chrono::seconds(1));
  const auto report = Get("wait", "mermaid");
  EXPECT_EQ(report.error, "");
  EXPECT_TRUE(report.stepping);
  EXPECT_EQ(report.feedback.goal_id, "ab12");
  EXPECT_EQ(report.feedback.status, msg::SkillFeedback::kStatusProcessing);
  EXPECT_EQ(report.feedback.state, "WAITING");
  EXPECT_EQ(report.feedback.progress, 25);
  EXPECT_EQ(report.feedback.message, "Waiting");
  EXPECT_THAT(report.feedback.details, ElementsAre(msg::SkillDetail{"left_s", "3"},
                                                   msg::SkillDetail{"requested_by", "alice@desk"}));
  EXPECT_THAT(report.history, ElementsAre("0.00 s IDLE → WAITING: requested"));
  EXPECT_THAT(report.graph, HasSubstr("stateDiagram-v2"));
  EXPECT_NE(report.graph, Get("twice", "mermaid").graph);
  manager_.CancelAllNow("a test");
  EXPECT_THAT(Get("wait", "dot").graph, HasSubstr("digraph"));
  EXPECT_THAT(Get("wait").history.back(), HasSubstr("WAITING → CANCELLED: cancelled"));
}

TEST_F(ASkillReport, KeepsTheReasonOfAFailure) {
  ASSERT_TRUE(manager_.Start("wait", {{"duration_s", -4.0}}));
  manager_.RunOnce(Time{});
  const auto report = Get("wait");
  EXPECT_EQ(report.feedback.status, msg::SkillFeedback::kStatusFailed);
  EXPECT_THAT(report.errors, ElementsAre("0.00 s WAITING: duration_s is negative"));
}

TEST_F(ASkillReport, ShowsASkillThatHasNotRunAsIdle) {
  const auto report = Get("wait", "dot");
  EXPECT_EQ(report.feedback.state, "IDLE");
  EXPECT_EQ(report.feedback.goal_id, "");
  EXPECT_THAT(report.feedback.details, IsEmpty());
  EXPECT_THAT(report.history, IsEmpty());
  EXPECT_THAT(report.graph, HasSubstr("IDLE"));
}

TEST_F(ASkillReport, NamesTheNearestSkillAndTheFormats) {
  EXPECT_THAT(Get("wiat").error, HasSubstr("did you mean 'wait'?"));
  EXPECT_EQ(Get("wait", "png").error, "unknown graph format; expected dot or mermaid");
}

}  // namespace musher::skill_report_test
