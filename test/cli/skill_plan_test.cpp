// musher skill plan: the file, its errors, the progress, and the ends of a plan.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "musher/cli/commands/skill/plan_file.hpp"
#include "musher/cli/render/skill_plan.hpp"
#include "musher/test/cli/fake_skills.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::skill_plan_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<std::string> Lines(const std::vector<Diagnostic>& diagnostics) {
  std::vector<std::string> lines;
  for (const Diagnostic& found : diagnostics) lines.push_back(FormatDiagnostic(found));
  return lines;
}

constexpr const char* kPlan = R"([[step]]
jetbot_0 = { skill = "nav_2d", goal_pos = [5.6, 1, 0], text = "two words", quick = true }
cf2x_0 = { skill = "rise", altitude = 1.5 }

[[step]]
cf2x_0 = { skill = "explore", boundary = [[0, 0], [5.5, 0]], names = ["a\"b"] }
)";

TEST(PlanFileReader, ReadsStepsWithTheSkillOfEachRobot) {
  const PlanFileReading reading = ReadPlanText(kPlan, "plan.toml");
  ASSERT_TRUE(reading.plan) << Lines(reading.diagnostics).front();
  const msg::SkillPlan plan = ToMessage(*reading.plan);
  ASSERT_THAT(plan.steps, SizeIs(2));
  EXPECT_EQ(plan.steps[0].timestep, 1);
  EXPECT_EQ(plan.steps[1].timestep, 2);
  ASSERT_THAT(plan.steps[0].robots, SizeIs(2));
  EXPECT_EQ(plan.steps[0].robots[0].robot_id, "jetbot_0");
  const msg::SkillInfo& drive = plan.steps[0].robots[0].skill_list.at(0);
  EXPECT_EQ(drive.skill, "nav_2d");
  EXPECT_THAT(drive.params, ElementsAre(msg::SkillParameter{"goal_pos", "[5.6, 1, 0]"},
                                        msg::SkillParameter{"text", "two words"},
                                        msg::SkillParameter{"quick", "true"}));
  EXPECT_THAT(plan.steps[1].robots[0].skill_list.at(0).params,
              ElementsAre(msg::SkillParameter{"boundary", "[[0, 0], [5.5, 0]]"},
                          msg::SkillParameter{"names", "[\"a\\\"b\"]"}));
}

TEST(PlanFileReader, ReportsEveryErrorWithItsPlace) {
  const PlanFileReading reading = ReadPlanText(R"(steps = 1
[[step]]
jetbot_0 = "nav_2d"
"jetbot 1" = { skill = "nav_2d" }
cf2x_0 = { skil = "take_off", when = 2026-01-01 }
[[step]]
)",
                                               "plan.toml");
  EXPECT_FALSE(reading.plan);
  EXPECT_THAT(Lines(reading.diagnostics),
              ElementsAre(HasSubstr("plan.toml:1:1: error: unknown key \"steps\"; did you mean "
                                    "\"step\"?"),
                          HasSubstr("plan.toml:3:12: error: step 1.jetbot_0: expected a table"),
                          HasSubstr("plan.toml:4:1: error: step 1: \"jetbot 1\" is not the name"),
                          HasSubstr("plan.toml:5:1: error: step 1.cf2x_0: the key \"skill\" is"),
                          HasSubstr("plan.toml:5:38: error: step 1.cf2x_0.when: expected a text"),
                          HasSubstr("plan.toml:6:1: error: step 2: has no robots")));
  EXPECT_THAT(Lines(ReadPlanText("", "plan.toml").diagnostics),
              ElementsAre(HasSubstr("[[step]], once for each step of the plan")));
}

TEST(PlanFileReader, ComparesThePlanWithTheSkillsThatAreOffered) {
  const PlanFile plan = *ReadPlanText(R"([[step]]
cf2x_0 = { skill = "rise", altitud = 1 }
cf2x_1 = { skill = "ries" }
other = { skill = "anything", key = 1 }
)",
                                      "plan.toml")
                             .plan;
  const std::vector<std::string> parameters{"altitude: a number, default 1 (m)",
                                            "goal: a list of numbers, required (m)"};
  const std::vector<msg::SkillOffers> offers{
      {"cf2x_0", "/cf2x_0/skill_execution", {{"rise", "", parameters}}},
      {"cf2x_1", "/fleet/cf2x_1/skill_execution", {{"rise", "", {}}}}};
  EXPECT_THAT(
      Lines(CheckPlanFile(plan, offers, "plan.toml")),
      ElementsAre("plan.toml:2:20: error: cf2x_0 rise: the parameter goal: a list of numbers, "
                  "required (m) is missing",
                  "plan.toml:2:28: error: cf2x_0 rise: there is no parameter 'altitud'; did you "
                  "mean 'altitude'? There are altitude and goal",
                  "plan.toml:3:20: error: cf2x_1: there is no skill 'ries'; did you mean 'rise'? "
                  "There is only rise"));
}

TEST(ReportOfAPlan, HasTheChangesAndTheProgressOfTheWhole) {
  PlanReport report(2);
  const msg::PlanSkillFeedback drives{"jetbot_0", "nav_2d", "ab", "processing: Moving (50%)"};
  const msg::PlanSkillFeedback rises{"cf2x_0", "rise", "cd", "completed: Reached altitude (100%)"};
  EXPECT_THAT(report.Take({1, {drives, {"cf2x_0", "rise", "", ""}}}), SizeIs(1));
  EXPECT_THAT(report.Take({1, {drives, rises}}), SizeIs(1));
  EXPECT_THAT(report.Take({1, {drives, rises}}), IsEmpty());
  EXPECT_EQ(report.Summary(),
            (SkillReport{"processing", "jetbot_0 nav_2d 50 %, cf2x_0 rise 100 %", 37}));
  const auto next = report.Take({2, {drives}});
  ASSERT_THAT(next, SizeIs(1));
  EXPECT_EQ(report.Summary().progress, 75);
  EXPECT_EQ(PlanMemberLine(next[0], 2), "step 2 of 2  jetbot_0  nav_2d   50 %  Moving\n");
}

// Serves plan_execution: with a plan of one step, whose first skill says how the plan ends.
class FakeDispatcher {
 public:
  using Goal = transport::ServerGoal<msg::PlanExecution>;

  // With a `machine` it publishes the status of an actuator of that machine, of another host.
  explicit FakeDispatcher(const MachineIdentity& machine = {}, const std::string& name = "plans")
      : thread_(transport::NodeThread::Start().value()) {
    thread_->RunOnLoop([&] {
      endpoints_ = std::make_unique<transport::Endpoints>(thread_->node(), "");
      transport::ActionHandlers<msg::PlanExecution> handlers;
      handlers.start = [this](Goal goal) { Start(goal); };
      handlers.cancel = [this](Goal goal) {
        goal.Canceled({false, "Cancelled in timestep 1: by the client"});
        goal_.reset();
      };
      endpoints_->ServeAction<msg::PlanExecution>("plan_execution", handlers);
      if (!machine.name.empty()) PublishStatusOf(*endpoints_, name, machine);
    });
  }
  ~FakeDispatcher() {
    thread_->RunOnLoop([this] {
      endpoints_.reset();
      goal_.reset();
    });
  }
  FakeDispatcher(const FakeDispatcher&) = delete;
  FakeDispatcher& operator=(const FakeDispatcher&) = delete;

  int plans() {
    int plans = 0;
    thread_->RunOnLoop([&] { plans = plans_; });
    return plans;
  }

 private:
  void Start(Goal goal) {
    ++plans_;
    const msg::RobotSkill& first = goal.goal().plan.steps.at(0).robots.at(0);
    const std::string skill = first.skill_list.at(0).skill;
    if (skill == "refuse") return static_cast<void>(goal.Abort({false, "another plan runs"}));
    goal.Execute();
    goal.PublishFeedback({1, {{first.robot_id, skill, "ab", "processing: Begun (10%)"}}});
    if (skill == "rise") goal.Succeed({true, "All timesteps completed."});
    if (skill == "fail") goal.Abort({false, "Execution failed in timestep 1. no path"});
    if (skill == "wait") goal_ = goal;
  }

  std::shared_ptr<transport::NodeThread> thread_;
  std::optional<Goal> goal_;
  int plans_ = 0;
  std::unique_ptr<transport::Endpoints> endpoints_;
};

class PlanCommand : public ::testing::Test {
 protected:
  PlanCommand() { setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1); }
  std::string File(const std::string& skill) {
    const std::string path = folder_ / "plan.toml";
    std::ofstream(path) << "[[step]]\ncf2x_0 = { skill = \"" << skill << "\" }\n";
    return path;
  }
  static nlohmann::json Json(const std::string& text) {
    return nlohmann::json::parse(text, nullptr, false);
  }

  const TempFolder folder_;
};

TEST_F(PlanCommand, ShowsTheProgressOfThePlanAndItsEnd) {
  const FakeDispatcher dispatcher;
  const FakeSkills robot("cf2x_0");
  const Ran ran = RunProgram({"skill", "plan", File("rise")});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("the plan completed in "));
  EXPECT_THAT(ran.out, HasSubstr(": All timesteps completed."));
  const Ran json = RunProgram({"--json", "skill", "plan", File("rise")});
  EXPECT_EQ(Json(json.out)["outcome"], "completed") << json.out << json.err;
  EXPECT_EQ(Json(json.out)["steps"], 1);
}

TEST_F(PlanCommand, ExitsByTheOutcome) {
  const FakeDispatcher dispatcher;
  const FakeSkills robot("cf2x_0");
  const Ran failed = RunProgram({"--json", "skill", "plan", File("fail")});
  EXPECT_EQ(failed.exit, 1);
  EXPECT_THAT(failed.err, HasSubstr(": Execution failed in timestep 1. no path"));
  const Ran refused = RunProgram({"--json", "skill", "plan", File("refuse")});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_EQ(Json(refused.out)["outcome"], "refused") << refused.out;
  EXPECT_THAT(refused.err, HasSubstr("the plan was refused: another plan runs"));
  const Ran late = RunProgram({"--json", "skill", "plan", File("wait"), "--timeout", "1.5"});
  EXPECT_EQ(late.exit, 4);
  EXPECT_EQ(Json(late.out)["outcome"], "timeout");
  EXPECT_THAT(late.err, HasSubstr("the plan has not ended within 1.5 s: Cancelled in timestep 1"));
  EXPECT_EQ(Json(late.out)["skills"][0]["robot"], "cf2x_0") << late.out;
}

TEST_F(PlanCommand, CancelsThePlanByCtrlC) {
  const FakeDispatcher dispatcher;
  const FakeSkills robot("cf2x_0");
  testing::Process run({BinDir() + "/musher", "skill", "plan", File("wait")});
  ASSERT_EQ(run.LineWith("Begun"), "step 1 of 1  cf2x_0  wait   10 %  Begun");
  run.Signal(SIGINT);
  const testing::Ended ended = run.Wait();
  EXPECT_EQ(ended.exit, 130);
  EXPECT_THAT(ended.err, HasSubstr("cancelling the plan; Ctrl-C again returns without waiting"));
  EXPECT_THAT(ended.err, HasSubstr("the plan was cancelled after "));
}

const MachineIdentity kDog{"dog", "d0900000-0000-4000-8000-000000000002"};
const MachineIdentity kCat{"cat", "cafe0000-0000-4000-8000-000000000001"};

TEST_F(PlanCommand, SendsNoPlanToTheDispatcherOfAnotherMachine) {
  FakeDispatcher of_cat(kCat);
  const FakeSkills robot("cf2x_0");
  const Ran of_dog = RunProgram({"skill", "plan", File("rise"), "--machine", "dog"});
  EXPECT_EQ(of_dog.exit, 3) << of_dog.out;
  EXPECT_THAT(of_dog.err, HasSubstr("no plan dispatcher of machine dog in the default namespace; "
                                    "found cat (id cafe0000). Nothing was done"));
  EXPECT_EQ(of_cat.plans(), 0);
  EXPECT_EQ(RunProgram({"skill", "plan", File("rise"), "--machine", "cat"}).exit, 0);
  EXPECT_EQ(of_cat.plans(), 1);
}

// Both would execute it, whatever their names are.
TEST_F(PlanCommand, SendsNoPlanWhereTheDispatchersOfTwoMachinesWouldReceiveIt) {
  FakeDispatcher of_cat(kCat, "cat_plans"), of_dog(kDog, "dog_plans");
  const FakeSkills robot("cf2x_0");
  const std::string file = File("rise");
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{}, {"--machine", "dog"}}) {
    std::vector<std::string> words{"skill", "plan", file};
    words.insert(words.end(), more.begin(), more.end());
    const Ran ran = RunProgram(words);
    EXPECT_EQ(ran.exit, 2) << ran.out;
    EXPECT_THAT(ran.err, HasSubstr("several machines have a plan dispatcher in the default "
                                   "namespace: "));
    EXPECT_THAT(ran.err, HasSubstr("Nothing was done"));
  }
  EXPECT_EQ(of_cat.plans() + of_dog.plans(), 0);
}

TEST_F(PlanCommand, RefusesAPlanBeforeItIsSent) {
  const Ran none = RunProgram({"skill", "plan", folder_ / "none.toml"});
  EXPECT_EQ(none.exit, 2);
  EXPECT_THAT(none.err, HasSubstr("none.toml: error: "));
  const Ran alone = RunProgram({"skill", "plan", File("rise")});
  EXPECT_EQ(alone.exit, 3);
  EXPECT_THAT(alone.err, HasSubstr("no plan dispatcher in the default namespace"));
  const FakeDispatcher dispatcher;
  const FakeSkills robot("cf2x_0");
  const Ran unknown = RunProgram({"skill", "plan", File("ries")});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err, HasSubstr("plan.toml:2:20: error: cf2x_0: there is no skill 'ries'; did "
                                     "you mean 'rise'?"));
}

}  // namespace musher::cli::skill_plan_test
