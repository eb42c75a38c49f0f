// The execution of a plan, without a network.

#include "musher/modules/skills/plan/plan_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "musher/modules/skills/plan/plan_check.hpp"

namespace musher::skills::plan_run_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Robots of a step with their skills.
using Step = std::vector<std::pair<std::string, std::string>>;

msg::SkillPlan PlanOf(const std::vector<Step>& steps) {
  msg::SkillPlan plan;
  std::int32_t number = 10;
  for (const Step& robots : steps) {
    msg::TimestepSkills step{number++, {}};
    for (const auto& [robot, name] : robots) {
      msg::SkillInfo skill;
      skill.skill = name;
      step.robots.push_back({robot, {skill}});
    }
    plan.steps.push_back(step);
  }
  return plan;
}

// A step in which each of these robots drives to a place.
msg::TimestepSkills Drives(const std::vector<std::pair<std::string, std::string>>& places) {
  msg::TimestepSkills step{7, {}};
  for (const auto& [robot, place] : places) {
    msg::SkillInfo skill;
    skill.skill = "navigate_to";
    skill.params = {{"goal_pos", place}};
    step.robots.push_back({robot, {skill}});
  }
  return step;
}

class APlan : public ::testing::Test {
 protected:
  PlanRun Begin(const std::vector<Step>& steps) { return {PlanOf(steps), {}, now_}; }
  PlanActions Advance(PlanRun& run, Duration step = {}) {
    now_ += step;
    return run.Advance(now_, [this](const std::string& robot) { return !gone_.contains(robot); });
  }

  Time now_{};
  std::set<std::string> gone_;
};

TEST_F(APlan, ExecutesItsStepsInOrderWithAllRobotsOfAStepTogether) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "wait"}}, {{"a", "move"}}});
  EXPECT_THAT(Advance(run).send, ElementsAre(0, 1));
  run.OnEnd(0, true, "completed");
  EXPECT_THAT(Advance(run).send, IsEmpty());
  run.OnEnd(1, true, "completed");
  EXPECT_THAT(Advance(run).send, ElementsAre(0));
  EXPECT_EQ(run.present().timestep, 11);
  run.OnEnd(0, true, "completed");
  EXPECT_EQ(Advance(run).end, (PlanEnd{PlanOutcome::kSucceeded, "All timesteps completed."}));
}

TEST_F(APlan, SendsNothingUntilAllServersOfTheStepAreAvailable) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "wait"}}});
  gone_ = {"b"};
  EXPECT_THAT(Advance(run).send, IsEmpty());
  EXPECT_THAT(Advance(run, Milliseconds(2999)).send, IsEmpty());
  gone_.clear();
  EXPECT_THAT(Advance(run).send, ElementsAre(0, 1));
}

TEST_F(APlan, EndsAfterThreeSecondsWithoutAServerAndNamesTheRobots) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "wait"}}});
  gone_ = {"b"};
  static_cast<void>(Advance(run));
  EXPECT_EQ(Advance(run, Milliseconds(3000)).end,
            (PlanEnd{PlanOutcome::kAborted,
                     "Execution failed in timestep 10. no action server "
                     "within 3.0 s: b"}));
}

TEST_F(APlan, CancelsTheOthersOfTheStepAtAFailureAndWaitsForTheirEnds) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "move"}, {"c", "wait"}}, {{"a", "wait"}}});
  static_cast<void>(Advance(run));
  run.OnEnd(2, true, "completed");
  run.OnEnd(1, false, "failed: no path (15%)");
  PlanActions actions = Advance(run);
  EXPECT_THAT(actions.cancel, ElementsAre(0));
  EXPECT_FALSE(actions.end);
  EXPECT_THAT(Advance(run, Milliseconds(50)).cancel, IsEmpty());
  run.OnEnd(0, false, "cancelled");
  EXPECT_EQ(Advance(run).end,
            (PlanEnd{PlanOutcome::kAborted,
                     "Execution failed in timestep 10. b move: failed: no path (15%)"}));
}

TEST_F(APlan, CancelsAllAndStartsNothingMore) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "wait"}}, {{"a", "wait"}}});
  static_cast<void>(Advance(run));
  run.Cancel("by its client", true);
  EXPECT_THAT(Advance(run).cancel, ElementsAre(0, 1));
  run.OnEnd(0, true, "completed");  // it was faster
  run.OnEnd(1, false, "cancelled");
  EXPECT_EQ(Advance(run).end,
            (PlanEnd{PlanOutcome::kCanceled, "Cancelled in timestep 10: by its client"}));
}

TEST_F(APlan, IsCancelledAtOnceWhileItWaitsForAServer) {
  PlanRun run = Begin({{{"a", "wait"}}});
  gone_ = {"a"};
  static_cast<void>(Advance(run));
  run.Cancel("it is in LowPower", false);
  EXPECT_EQ(Advance(run).end,
            (PlanEnd{PlanOutcome::kAborted, "Cancelled in timestep 10: it is in LowPower"}));
}

TEST_F(APlan, EndsWithoutARobotThatDoesNotEndAfterItsCancellation) {
  PlanRun run = Begin({{{"a", "wait"}}});
  static_cast<void>(Advance(run));
  run.Cancel("by its client", true);
  static_cast<void>(Advance(run));
  EXPECT_FALSE(Advance(run, Milliseconds(9999)).end);
  const PlanActions late = Advance(run, Milliseconds(1));
  ASSERT_TRUE(late.end);
  EXPECT_THAT(late.end->message, HasSubstr("not ended 10.0 s after their cancellation: a wait"));
}

TEST_F(APlan, PublishesAllRobotsOfTheStepAtEachChange) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "wait"}}});
  EXPECT_TRUE(Advance(run).feedback);
  EXPECT_FALSE(Advance(run).feedback);
  run.OnSent(0, "0a");
  run.OnFeedback(0, "processing: Waiting (5%)");
  EXPECT_TRUE(Advance(run).feedback);
  run.OnFeedback(0, "processing: Waiting (5%)");
  EXPECT_FALSE(Advance(run).feedback);
  const auto feedback = run.Feedback();
  EXPECT_EQ(feedback.current_timestep, 10);
  EXPECT_THAT(feedback.skill_statuses,
              ElementsAre(msg::PlanSkillFeedback{"a", "wait", "0a", "processing: Waiting (5%)"},
                          msg::PlanSkillFeedback{"b", "wait", "", "sent"}));
}

TEST(PlanCheck, NamesEachErrorWithItsStepAndRobot) {
  EXPECT_TRUE(CheckPlan(PlanOf({{{"a", "wait"}}})));
  EXPECT_EQ(CheckPlan({}).error().message, "the plan has no steps");
  msg::SkillPlan plan = PlanOf({{{"a", "wait"}, {"a", "wait"}}, {}, {{"b/c", "wait"}, {"d", ""}}});
  plan.steps[0].robots[0].skill_list.clear();
  EXPECT_EQ(CheckPlan(plan).error().message,
            "step 1 (timestep 10), a: expected one skill in skill_list, found 0\n"
            "step 1 (timestep 10), a: is in this step twice\n"
            "step 2 (timestep 11): has no robots\n"
            "step 3 (timestep 12), robot 1: \"b/c\" is not the name of a robot; expected a name "
            "of letters, digits and '_' that begins with no digit, at most 64 long\n"
            "step 3 (timestep 12), d: the skill has no name");
}

TEST(PlanCheck, CountsWhatItDoesNotList) {
  msg::SkillPlan plan;
  plan.steps.resize(25);
  EXPECT_THAT(CheckPlan(plan).error().message, HasSubstr("\nand 5 more"));
}

TEST_F(APlan, SaysWhyTheOtherRobotsOfAFailedStepAreCancelled) {
  PlanRun run = Begin({{{"a", "wait"}, {"b", "move"}}});
  static_cast<void>(Advance(run));
  run.OnEnd(1, false, "failed: no path (15%)");
  EXPECT_THAT(Advance(run).cancel, ElementsAre(0));
  run.OnEnd(0, false, "cancelled: by its client (20%)");
  EXPECT_EQ(run.Feedback().skill_statuses[0].status,
            "cancelled: with its plan, in which b move: failed: no path (15%)");
}

TEST(APlanCheck, RefusesTwoRobotsInOnePlaceWithBothNames) {
  const auto check = [](const std::vector<msg::TimestepSkills>& steps) {
    const Result<> checked = CheckPlan({steps});
    return checked ? std::string("ok") : checked.error().message;
  };
  EXPECT_EQ(check({Drives({{"a", "[2.0, 3.0, 0]"}, {"b", "[2.1, 3.2]"}})}),
            "step 1 (timestep 7): a and b both go to (2.00, 3.00); send one of them to another "
            "place");
  EXPECT_EQ(check({Drives({{"a", "[2, 3]"}}), Drives({{"b", "[2, 3]"}})}),
            "step 2 (timestep 7): b goes to (2.00, 3.00), where a is since step 1; send a away "
            "first");
  EXPECT_EQ(check({Drives({{"a", "[2, 3]"}}), Drives({{"a", "[5, 3]"}, {"b", "[2, 3]"}})}), "ok")
      << "it leaves the place";
  EXPECT_EQ(check({Drives({{"a", "[2, 3, 0]"}, {"b", "[2, 3, 1.5]"}})}), "ok")
      << "a flyer above it";
  EXPECT_EQ(check({Drives({{"a", "[2, 3]"}, {"b", "nowhere"}, {"c", "[nan, 3]"}})}), "ok")
      << "their skills refuse it";
}

}  // namespace musher::skills::plan_run_test
