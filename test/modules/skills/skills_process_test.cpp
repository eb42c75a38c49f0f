// The real programs over DDS, driven as a controller drives them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/plan_msgs/plan.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/transport/action.hpp"

namespace musher::skills::skills_process_test {

using ::testing::HasSubstr;

class SkillsProcess : public test::ModuleProcess {
 protected:
  SkillsProcess() : ModuleProcess("r", "musher-skills") {
    odometry_ = Publisher<msg::Odometry>("r/odom");
    Subscribe<msg::Twist>("r/cmd_vel",
                          [this](const msg::Twist& twist) { commands_.push_back(twist); });
    client_ =
        transport::MakeActionClient<msg::SkillExecution>(peer_.node(), "r/skill_execution").value();
    again_ = peer_.node().loop().Every(Milliseconds(20),
                                       [this] { static_cast<void>(odometry_->Publish({})); });
  }
  void Begin(const std::string& more = "") {
    ASSERT_NO_FATAL_FAILURE(
        Start("robot = \"r\"\nkind = \"cf2x\"\nflies = true\nself_check_ms = 1000\n" + more));
    ASSERT_TRUE(peer_.Switch("SelfCheck")) << peer_.Output();
    ASSERT_TRUE(peer_.Switch("Active")) << peer_.Output();
  }
  // A flyer, which is commanded to rise.
  void BeginToRise(const std::string& more = "") {
    ASSERT_NO_FATAL_FAILURE(Begin(more));
    msg::SkillInfo skill;
    skill.skill = "take_off";
    skill.params = {{"altitude", "2"}};
    client_->SendGoal({{"r", {skill}}}, std::chrono::seconds(120), {});
    ASSERT_TRUE(peer_.Until([this] { return !commands_.empty() && commands_.back().linear.z > 0; }))
        << peer_.Output();
  }

  // Killed in take_off, and started again.
  void RiseAgain(const std::string& more) {
    ASSERT_NO_FATAL_FAILURE(BeginToRise(more));
    ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
    peer_.Signal(SIGKILL);
    ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
    commands_.clear();
    ASSERT_NO_FATAL_FAILURE(Begin(more));
  }
  msg::SkillFeedback FeedbackOfTakeOff() {
    msg::GetSkill::Request request;
    request.skill = "take_off";
    return Call<msg::GetSkill>("r/get_skill", request).feedback;
  }

  // Pauses or resumes take_off: "true EXECUTING", as the service answers.
  std::string Pause(bool pause) {
    msg::PauseSkill::Request request;
    request.skill = "take_off";
    request.pause = pause;
    const auto answer = Call<msg::PauseSkill>("r/pause_skill", request);
    return (answer.success ? "true " : "false ") + answer.message;
  }
  // What `musher` with these words prints, while the robot goes on.
  std::string Musher(std::vector<std::string> words) {
    words.insert(words.begin(), "musher");
    Run(std::move(words));
    return Said();
  }
  // For a second no command rises, once those have arrived that were sent before.
  void ExpectNoRise() {
    int looks = 0;
    const auto look = peer_.node().loop().Every(Milliseconds(50), [&looks] { ++looks; });
    ASSERT_TRUE(peer_.Until(
        [&] { return commands_.empty() || commands_.back().linear.z <= 0.01 || looks >= 10; }));
    commands_.clear();
    looks = 0;
    ASSERT_TRUE(peer_.Until([&looks] { return looks == 20; }));
    for (const msg::Twist& command : commands_) EXPECT_LE(command.linear.z, 0.01);
  }
  bool Rises() {
    commands_.clear();
    return peer_.Until([this] { return !commands_.empty() && commands_.back().linear.z > 0.1; });
  }

  std::vector<msg::Twist> commands_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::ActionClient<msg::SkillExecution>> client_;
  transport::LoopHandlePtr again_;
};

TEST_F(SkillsProcess, StandsWhenItIsTerminated) {
  BeginToRise();
  peer_.Signal(SIGTERM);
  EXPECT_TRUE(peer_.Until([this] { return commands_.back() == msg::Twist{}; })) << peer_.Output();
  peer_.AwaitExit();
}

TEST_F(SkillsProcess, StandsInLowPower) {
  BeginToRise();
  ASSERT_TRUE(peer_.Switch("LowPower")) << peer_.Output();
  EXPECT_TRUE(peer_.Until([this] { return commands_.back() == msg::Twist{}; })) << peer_.Output();
}

TEST_F(SkillsProcess, ThatWasKilledReportsItsSkillAsFailedWithTheReasonAndStands) {
  ASSERT_NO_FATAL_FAILURE(RiseAgain(""));
  const msg::SkillFeedback feedback = FeedbackOfTakeOff();
  EXPECT_EQ(feedback.status, msg::SkillFeedback::kStatusFailed) << peer_.Output();
  EXPECT_EQ(feedback.message, "its process has ended while it ran (EXECUTING)");
  for (const msg::Twist& command : commands_) EXPECT_LE(command.linear.z, 0.3);
  EXPECT_THAT(peer_.Output(), HasSubstr("take_off has failed: its process has ended"));
}

TEST_F(SkillsProcess, ThatWasKilledGoesOnIfItsConfigSaysSo) {
  ASSERT_NO_FATAL_FAILURE(RiseAgain("after_restart = \"continue\"\n"));
  EXPECT_TRUE(peer_.Until([this] { return !commands_.empty() && commands_.back().linear.z > 0; }))
      << peer_.Output();
  EXPECT_EQ(FeedbackOfTakeOff().status, msg::SkillFeedback::kStatusProcessing);
}

// A client's goal has ended with the killed process: nothing but the command line could name it.
TEST_F(SkillsProcess, ThatGoesOnAfterAKillIsCancelledByHand) {
  ASSERT_NO_FATAL_FAILURE(RiseAgain("after_restart = \"continue\"\n"));
  ASSERT_TRUE(Rises()) << peer_.Output();
  EXPECT_EQ(FeedbackOfTakeOff().goal_id, "");
  EXPECT_EQ(Musher({"skill", "cancel", "take_off"}),
            "take_off of r was cancelled: by " + UserAtHost() + "\n");
  EXPECT_EQ(FeedbackOfTakeOff().status, msg::SkillFeedback::kStatusCancelled) << peer_.Output();
  ExpectNoRise();
  EXPECT_EQ(Musher({"skill", "cancel", "take_off"}),
            "musher: take_off is not running; offered by r\n");
}

// It drove on by itself when its controller had started it again.
TEST_F(SkillsProcess, ThatWasTerminatedHasCancelledItsSkillsAndGoesOnWithNone) {
  const std::string more = "after_restart = \"continue\"\n";
  ASSERT_NO_FATAL_FAILURE(BeginToRise(more));
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGTERM);
  ASSERT_EQ(peer_.AwaitExit(), -SIGTERM);
  ASSERT_NO_FATAL_FAILURE(Begin(more));
  ExpectNoRise();
  EXPECT_THAT(peer_.Output(), ::testing::Not(HasSubstr("goes on")));
  EXPECT_EQ(FeedbackOfTakeOff().state, "IDLE");
}

TEST_F(SkillsProcess, PausesOneSkillAlsoOverAPauseOfTheRobot) {
  ASSERT_NO_FATAL_FAILURE(BeginToRise());
  EXPECT_EQ(Pause(true), "true EXECUTING");
  ExpectNoRise();
  EXPECT_THAT(FeedbackOfTakeOff().message, ::testing::StartsWith("paused: "));
  ASSERT_TRUE(peer_.Switch("LowPower")) << peer_.Output();
  EXPECT_EQ(Pause(false), "false r runs no skills in LowPower");
  ASSERT_TRUE(peer_.Switch("Active")) << peer_.Output();
  ExpectNoRise();
  EXPECT_EQ(Pause(false), "true EXECUTING");
  EXPECT_TRUE(Rises()) << peer_.Output();
}

TEST_F(SkillsProcess, ThatWasKilledWithAPausedSkillMovesNothingByItself) {
  const std::string more = "after_restart = \"continue\"\n";
  ASSERT_NO_FATAL_FAILURE(BeginToRise(more));
  EXPECT_EQ(Pause(true), "true EXECUTING");
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  ASSERT_NO_FATAL_FAILURE(Begin(more));
  ExpectNoRise();
  EXPECT_THAT(peer_.Output(), HasSubstr("take_off stays paused in EXECUTING until it is resumed"));
  EXPECT_EQ(Pause(false), "true EXECUTING");
  EXPECT_TRUE(Rises()) << peer_.Output();
}

TEST_F(SkillsProcess, ExitsWithCode2AndTheErrorsOfItsConfig) {
  ExpectRefused("robot = \"r\"\nkindd = \"cf2x\"\nradius_m = 0\n",
                "unknown key \"kindd\"; did you mean \"kind\"?");
  EXPECT_THAT(peer_.Output(), HasSubstr(":3:12: error: radius_m: "));
}

class DispatcherProcess : public test::ModuleProcess {
 protected:
  DispatcherProcess() : ModuleProcess("plan_dispatcher", "musher-plan-dispatcher") {}
};

TEST_F(DispatcherProcess, ExitsWithCode2AndTheErrorsOfItsConfig) {
  ExpectRefused("server_wait = 3\n", "did you mean \"server_wait_ms\"?");
}

TEST_F(DispatcherProcess, ThatIsKilledInAPlanCancelsItsGoalAndSendsNoneUntilTheNextPlan) {
  int goals = 0;
  std::vector<transport::ServerGoal<msg::SkillExecution>> kept;  // that never end
  transport::ActionHandlers<msg::SkillExecution> handlers;
  handlers.start = [&](transport::ServerGoal<msg::SkillExecution> goal) {
    ++goals;
    kept.push_back(std::move(goal));
  };
  handlers.cancel = [](transport::ServerGoal<msg::SkillExecution> goal) { goal.Canceled({}); };
  const auto robot = transport::MakeActionServer<msg::SkillExecution>(
                         peer_.node(), "r/skill_execution", std::move(handlers))
                         .value();
  const auto client =
      transport::MakeActionClient<msg::PlanExecution>(peer_.node(), "plan_execution").value();
  const auto begin = [&] {
    ASSERT_NO_FATAL_FAILURE(Start(""));
    ASSERT_TRUE(peer_.Switch("SelfCheck")) << peer_.Output();
    ASSERT_TRUE(peer_.Switch("Active")) << peer_.Output();
  };
  bool ended = false;
  const auto send = [&] {
    msg::SkillInfo skill;
    skill.skill = "wait";
    msg::PlanExecution::Goal goal;
    goal.plan.steps = {{1, {{"r", {skill}}}}};
    transport::GoalEvents<msg::PlanExecution> events;
    events.on_end = [&ended](const auto&) { ended = true; };
    client->SendGoal(goal, std::chrono::seconds(120), std::move(events));
  };
  ASSERT_NO_FATAL_FAILURE(begin());
  send();
  ASSERT_TRUE(peer_.Until([&] { return goals == 1; })) << peer_.Output();
  // So that the status of its successor is known from its own.
  ASSERT_TRUE(peer_.AwaitStatus([](const auto& report) { return report.state == "Active"; }));
  peer_.Signal(SIGKILL);
  ASSERT_EQ(peer_.AwaitExit(), -SIGKILL);
  ASSERT_TRUE(peer_.Until([&] { return ended; })) << "its client knows that it is lost";
  EXPECT_EQ(kept[0].state(), transport::GoalState::kAccepted);
  ASSERT_NO_FATAL_FAILURE(begin());
  EXPECT_TRUE(peer_.Until([&] { return kept[0].state() == transport::GoalState::kCanceled; }))
      << peer_.Output();
  int looks = 0;
  const auto look = peer_.node().loop().Every(Milliseconds(50), [&looks] { ++looks; });
  ASSERT_TRUE(peer_.Until([&looks] { return looks == 20; }));
  EXPECT_EQ(goals, 1);
  send();
  EXPECT_TRUE(peer_.Until([&] { return goals == 2; })) << peer_.Output();
}

}  // namespace musher::skills::skills_process_test
