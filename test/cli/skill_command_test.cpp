// `musher skill` and `musher graph --skill` with actuators that offer skills.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/base/host.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/cli/fake_skills.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::cli::skill_command_test {

using ::testing::AllOf;
using testing::Ended;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using testing::Process;

const std::string kMusher = BinDir() + "/musher";

class SkillCommand : public ::testing::Test {
 protected:
  // Without the robots that were run on this computer.
  SkillCommand() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("XDG_STATE_HOME", state_.path().c_str(), 1);
  }
  ~SkillCommand() override { unsetenv("XDG_STATE_HOME"); }
  static nlohmann::json Json(const std::string& text) {
    return nlohmann::json::parse(text, nullptr, false);
  }
  const TempFolder state_;
};

TEST_F(SkillCommand, ListsTheSkillsOfEveryActuatorAndTheParametersOfOne) {
  const FakeSkills zero("cf2x_0");
  const FakeSkills one("cf2x_1");
  const Ran ran = RunProgram({"skill", "list"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("cf2x_0  /cf2x_0/skill_execution\n"
                              "  rise    rises to an altitude\n"),
                    HasSubstr("\n  wait\n"), HasSubstr("cf2x_1  "), Not(HasSubstr("altitude: "))));
  const Ran rise = RunProgram({"skill", "list", "rise", "--actuator", "cf2x_1"});
  EXPECT_THAT(rise.out, HasSubstr("cf2x_1  /cf2x_1/skill_execution\n"
                                  "  rise  rises to an altitude\n"
                                  "      altitude: a number, default 1 (m above the ground)\n"));
  EXPECT_THAT(rise.out, AllOf(Not(HasSubstr("wait")), Not(HasSubstr("cf2x_0"))));
  const Ran unknown = RunProgram({"skill", "list", "ries"});
  EXPECT_EQ(unknown.exit, 1);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean 'rise'?"));
  const Ran of_one = RunProgram({"--json", "skill", "list", "--actuator", "cf2x_1"});
  const auto json = Json(of_one.out)["actuators"];
  EXPECT_EQ(json.size(), 1U) << of_one.out;
  EXPECT_EQ(json["cf2x_1"]["skills"][0]["parameters"][0]["key"], "altitude");
}

TEST_F(SkillCommand, RunsASkillWithItsParametersAndPrintsItsProgress) {
  FakeSkills robot("cf2x_0");
  const Ran ran = RunProgram({"skill", "run", "rise", "altitude=[1, 2]", "text=two words"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("rise of cf2x_0 completed in "));
  EXPECT_THAT(ran.out, HasSubstr(": Reached altitude\n"));
  EXPECT_EQ(robot.requested(), "altitude=[1, 2] text=two words ");
}

TEST_F(SkillCommand, PrintsOneJsonDocumentForARun) {
  const FakeSkills robot("cf2x_0");
  const Ran ran = RunProgram({"--json", "skill", "run", "fail"});
  EXPECT_EQ(ran.exit, 1);
  const auto json = Json(ran.out);
  EXPECT_EQ(json["outcome"], "failed") << ran.out;
  EXPECT_EQ(json["message"], "no path");
  EXPECT_EQ(json["progress"], 40);
  EXPECT_EQ(json["actuator"], "cf2x_0");
  EXPECT_EQ(json["goal_id"].get<std::string>().size(), 32U);
}

TEST_F(SkillCommand, PrintsWhyASkillWasRefused) {
  const FakeSkills robot("cf2x_0");
  const Ran ran = RunProgram({"skill", "run", "refuse"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_EQ(ran.err, "musher: refuse of cf2x_0 was refused: refuse is running already\n");
}

TEST_F(SkillCommand, SendsNothingForAnUnknownSkillOrKey) {
  FakeSkills robot("cf2x_0");
  const Ran skill = RunProgram({"skill", "run", "rize"});
  EXPECT_EQ(skill.exit, 1);
  EXPECT_THAT(skill.err, HasSubstr("there is no skill 'rize'; did you mean 'rise'?"));
  const Ran key = RunProgram({"skill", "run", "rise", "altitud=2"});
  EXPECT_EQ(key.exit, 1);
  EXPECT_THAT(key.err, HasSubstr("did you mean 'altitude'?"));
  EXPECT_EQ(robot.goals(), 0);
}

TEST_F(SkillCommand, RequiresAnActuatorWhereSeveralOfferTheSkill) {
  FakeSkills zero("cf2x_0");
  FakeSkills one("cf2x_1");
  const Ran ran = RunProgram({"skill", "run", "rise"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_EQ(ran.err,
            "musher: rise is offered by cf2x_0, cf2x_1; choose one of them with --actuator NAME\n");
  EXPECT_EQ(RunProgram({"skill", "run", "rise", "--actuator", "cf2x_1"}).exit, 0);
  EXPECT_EQ(zero.goals(), 0);
  EXPECT_EQ(one.goals(), 1);
  const Ran other = RunProgram({"skill", "run", "rise", "--actuator", "cf2x_2"});
  EXPECT_EQ(other.exit, 2);
  EXPECT_THAT(other.err,
              HasSubstr("no actuator 'cf2x_2' in the default namespace; did you mean 'cf2x_0'?"));
}

const MachineIdentity kDog{"dog", "d0900000-0000-4000-8000-000000000002"};
const MachineIdentity kCat{"cat", "cafe0000-0000-4000-8000-000000000001"};

// It ran on both robots.
TEST_F(SkillCommand, RunsNothingWhereTheActuatorsOfTwoMachinesWouldReceiveIt) {
  FakeSkills of_dog("arm", "", kDog);
  FakeSkills of_cat("arm", "", kCat);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"skill", "run", "rise"},
                                             {"skill", "run", "rise", "--actuator", "arm"},
                                             {"skill", "run", "rise", "--machine", "dog"}}) {
    const Ran ran = RunProgram(words);
    EXPECT_EQ(ran.exit, 2) << words.back() << ran.out;
    EXPECT_THAT(ran.err, AllOf(HasSubstr("arm is an actuator of several machines"),
                               HasSubstr("dog (id d0900000)"), HasSubstr("cat (id cafe0000)"),
                               HasSubstr("Nothing was done")));
  }
  EXPECT_EQ(of_dog.goals(), 0);
  EXPECT_EQ(of_cat.goals(), 0);
}

TEST_F(SkillCommand, RunsASkillOfTheMachineThatIsNamed) {
  FakeSkills of_dog("arm_0", "", kDog);
  FakeSkills of_cat("arm_1", "", kCat);
  const Ran other = RunProgram({"skill", "run", "rise", "--actuator", "arm_0", "--machine", "cat"});
  EXPECT_EQ(other.exit, 3) << other.out;
  EXPECT_THAT(other.err, HasSubstr("no actuator arm_0 of machine cat in the default namespace; "
                                   "found dog (id d0900000). Nothing was done"));
  for (const char* named : {"cat", "cafe0000"}) {
    const Ran ran = RunProgram({"skill", "run", "rise", "--machine", named});
    EXPECT_EQ(ran.exit, 0) << ran.err;
  }
  EXPECT_EQ(of_dog.goals(), 0);
  EXPECT_EQ(of_cat.goals(), 2);
}

// The robot on which it is typed does not run.
TEST_F(SkillCommand, RunsNoSkillOfAnotherMachineThanThisHostHasFilesOf) {
  {
    auto store = StateStore::Open(state_ / "musher/dog",
                                  {"dog", "", transport::TestDomain(), state_ / "robot.toml"});
    ASSERT_TRUE(store);
    store.value().SetMachineId(kDog.id);
    ASSERT_TRUE(store.value().SaveMachineId());
  }
  FakeSkills of_cat("arm", "", kCat);
  const Ran ran = RunProgram({"skill", "run", "rise"});
  EXPECT_EQ(ran.exit, 3) << ran.out;
  EXPECT_THAT(ran.err, AllOf(HasSubstr("the machine of this host, dog (id d0900000), has no "
                                       "running actuator arm"),
                             HasSubstr("found cat (id cafe0000). Nothing was done")));
  EXPECT_EQ(of_cat.goals(), 0);
}

// It paused and cancelled the skill of each robot, and let that of each go on.
TEST_F(SkillCommand, PausesResumesAndCancelsASkillOfTheMachineThatIsNamedAlone) {
  FakeSkills of_dog("arm_0", "", kDog);
  FakeSkills of_cat("arm_1", "", kCat);
  Process on_dog({kMusher, "skill", "run", "wait", "--actuator", "arm_0"});
  Process on_cat({kMusher, "skill", "run", "wait", "--actuator", "arm_1"});
  ASSERT_NE(on_dog.LineWith("10 %  Skill wait started"), "");
  ASSERT_NE(on_cat.LineWith("10 %  Skill wait started"), "");
  const Ran paused = RunProgram({"skill", "pause", "wait", "--machine", "cat"});
  EXPECT_EQ(paused.exit, 0) << paused.err;
  EXPECT_EQ(paused.out, "wait of arm_1 paused in WAITING\n");
  EXPECT_EQ(RunProgram({"skill", "resume", "wait", "--machine", "dog"}).exit, 1)
      << "it is not paused there";
  const Ran cancelled = RunProgram({"skill", "cancel", "wait", "--machine", "cat"});
  EXPECT_EQ(cancelled.exit, 0) << cancelled.err;
  EXPECT_EQ(on_cat.Wait().exit, 1);
  of_dog.Finish();
  EXPECT_EQ(on_dog.Wait().exit, 0);
}

// Each of the two names has one machine, so both robots went on.
TEST_F(SkillCommand, ResumesNothingWhereTwoMachinesHaveTheSkillAndNoneIsNamed) {
  FakeSkills of_dog("nav", "", kDog);
  FakeSkills of_cat("arm_nav", "", kCat);
  Process on_dog({kMusher, "skill", "run", "wait", "--actuator", "nav"});
  ASSERT_NE(on_dog.LineWith("10 %  Skill wait started"), "");
  for (const std::string command : {"pause", "resume", "cancel"}) {
    const Ran ran = RunProgram({"skill", command, "wait"});
    EXPECT_EQ(ran.exit, 2) << command << ran.out;
    EXPECT_THAT(ran.err, AllOf(HasSubstr("dog (id d0900000)"), HasSubstr("cat (id cafe0000)"),
                               HasSubstr("Nothing was done; --machine NAME means one of them")));
  }
  of_dog.Finish();
  EXPECT_EQ(on_dog.Wait().exit, 0);
}

TEST_F(SkillCommand, CancelsNothingWhereTheActuatorsOfTwoMachinesWouldReceiveIt) {
  const FakeSkills of_dog("arm", "", kDog);
  const FakeSkills of_cat("arm", "", kCat);
  for (const std::string command : {"cancel", "pause", "resume"}) {
    const Ran ran = RunProgram({"skill", command, "wait", "--machine", "dog"});
    EXPECT_EQ(ran.exit, 2) << command << ran.out;
    EXPECT_THAT(ran.err, HasSubstr("arm is an actuator of several machines"));
  }
}

TEST_F(SkillCommand, ReportsThatNothingRuns) {
  for (const std::string command : {"list", "run", "cancel", "pause", "resume", "watch"}) {
    std::vector<std::string> words = {"--namespace", "nowhere", "skill", command};
    if (command != "list" && command != "watch") words.emplace_back("rise");
    const Ran ran = RunProgram(words);
    EXPECT_EQ(ran.exit, 3);
    EXPECT_THAT(ran.err, HasSubstr("no actuator in namespace 'nowhere'"));
  }
}

TEST_F(SkillCommand, ReportsThatTheActuatorsThatRunOfferNoSkills) {
  const testing::RobotFile file({"lamp"}, {"SetUp"});
  ActuatorRunner<MachineActuator> lamp("lamp");
  lamp.RegisterStateCallback("SetUp", [] { return kCodeOk; });
  ASSERT_TRUE(lamp.Init(file.path()).ok());
  ASSERT_TRUE(lamp.Start().ok());
  const std::string here = testing::RobotFile::name_space();
  const Ran any = RunProgram({"--namespace", here, "skill", "list"});
  EXPECT_EQ(any.exit, 1);
  EXPECT_EQ(any.err,
            "musher: no actuator in namespace '" + here + "' offers skills; running: lamp\n");
  const Ran one = RunProgram({"--namespace", here, "skill", "run", "go", "--actuator", "lamp"});
  EXPECT_EQ(one.exit, 1);
  EXPECT_EQ(one.err, "musher: lamp runs but offers no skills\n");
}

TEST_F(SkillCommand, FindsTheSkillsOfItsNamespaceOnly) {
  const FakeSkills robot("cf2x_0", "fleet");
  EXPECT_EQ(RunProgram({"--namespace", "fleet", "skill", "run", "rise"}).exit, 0);
  EXPECT_EQ(RunProgram({"skill", "run", "rise"}).exit, 3);
}

TEST_F(SkillCommand, CancelsTheSkillOnCtrlCAndWaitsForItsEnd) {
  const FakeSkills robot("cf2x_0");
  Process run({kMusher, "skill", "run", "wait"});
  ASSERT_NE(run.LineWith("10 %  Skill wait started"), "");
  run.Signal(SIGINT);
  const Ended ended = run.Wait();
  EXPECT_EQ(ended.exit, 130);
  EXPECT_THAT(ended.err, HasSubstr("wait of cf2x_0 was cancelled after "));
}

TEST_F(SkillCommand, LeavesASkillThatIsNotCancelledAtTheSecondCtrlC) {
  FakeSkills robot("cf2x_0");
  Process run({kMusher, "--json", "skill", "run", "deaf"});
  ASSERT_TRUE(testing::Until([&] { return robot.goals() > 0; }));
  run.Signal(SIGINT);
  ASSERT_TRUE(run.AwaitError("refuses the cancellation of deaf"));
  run.Signal(SIGINT);
  const Ended ended = run.Wait();
  EXPECT_EQ(ended.exit, 130);
  EXPECT_THAT(ended.err,
              HasSubstr("deaf of cf2x_0 has not ended yet: its cancellation was requested; "
                        "`musher skill cancel deaf` requests it again"));
  EXPECT_EQ(Json(ended.out)["outcome"], "running");
}

TEST_F(SkillCommand, CancelsASkillThatDoesNotEndWithinItsTimeout) {
  const FakeSkills robot("cf2x_0");
  const Ran ran = RunProgram({"--json", "skill", "run", "wait", "--timeout", "1.5"});
  EXPECT_EQ(ran.exit, 4);
  EXPECT_EQ(Json(ran.out)["outcome"], "timeout");
  EXPECT_THAT(ran.err, MatchesRegex("musher: wait of cf2x_0 has not ended within 1.5 s: cancelled "
                                    "after [0-9.]+ s\n"));
}

TEST_F(SkillCommand, ReportsASkillWhoseActuatorIsLost) {
  auto robot = std::make_unique<FakeSkills>("cf2x_0");
  Process run({kMusher, "skill", "run", "wait"});
  ASSERT_NE(run.LineWith("10 %  Skill wait started"), "");
  robot.reset();
  const Ended ended = run.Wait();
  EXPECT_EQ(ended.exit, 5);
  EXPECT_THAT(ended.err, HasSubstr("wait of cf2x_0 is lost after "));
}

TEST_F(SkillCommand, CancelsTheRunOfAnotherClient) {
  const FakeSkills robot("cf2x_0");
  const FakeSkills other("cf2x_1");
  Process run({kMusher, "skill", "run", "wait", "--actuator", "cf2x_0"});
  ASSERT_NE(run.LineWith("10 %  Skill wait started"), "");
  const Ran ran = RunProgram({"skill", "cancel", "wait"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out, "wait of cf2x_0 was cancelled: by its client\n");
  EXPECT_EQ(run.Wait().exit, 1);
  const Ran again = RunProgram({"skill", "cancel", "wait"});
  EXPECT_EQ(again.exit, 1);
  EXPECT_EQ(again.err, "musher: wait is not running; offered by cf2x_0, cf2x_1\n");
}

TEST_F(SkillCommand, CancelsARunWithoutAGoalInTheNameOfItsUser) {
  FakeSkills robot("cf2x_0");
  robot.GoOnWithoutGoal("wait");
  const Ran ran = RunProgram({"skill", "cancel", "wait"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out, "wait of cf2x_0 was cancelled: by " + UserAtHost() + "\n");
  EXPECT_EQ(RunProgram({"skill", "cancel", "wait"}).err,
            "musher: wait is not running; offered by cf2x_0\n");
  robot.GoOnWithoutGoal("deaf");
  const Ran failed = RunProgram({"--json", "skill", "cancel", "deaf"});
  EXPECT_EQ(failed.exit, 1);
  EXPECT_EQ(Json(failed.out)["runs"][0]["outcome"], "failed") << failed.out;
  EXPECT_EQ(failed.err, "musher: deaf of cf2x_0 failed: it listens to no cancellation\n");
}

TEST_F(SkillCommand, PausesARunOfAnotherClientAndLetsItGoOn) {
  FakeSkills robot("cf2x_0");
  const FakeSkills other("cf2x_1");
  Process run({kMusher, "skill", "run", "wait", "--actuator", "cf2x_0"});
  ASSERT_NE(run.LineWith("10 %  Skill wait started"), "");
  const Ran paused = RunProgram({"skill", "pause", "wait"});
  EXPECT_EQ(paused.exit, 0) << paused.err;
  EXPECT_EQ(paused.out, "wait of cf2x_0 paused in WAITING\n");
  const Ran again = RunProgram({"skill", "pause", "wait"});
  EXPECT_EQ(again.exit, 1);
  EXPECT_EQ(again.err, "musher: cf2x_0: wait is paused already\n");
  const Ran resumed = RunProgram({"--json", "skill", "resume", "wait"});
  EXPECT_EQ(resumed.exit, 0) << resumed.err;
  EXPECT_EQ(Json(resumed.out)["runs"][0]["state"], "WAITING") << resumed.out;
  EXPECT_EQ(Json(resumed.out)["runs"][0]["done"], true);
  robot.Finish();
  EXPECT_EQ(run.Wait().exit, 0);
  EXPECT_EQ(RunProgram({"skill", "resume", "wait"}).err,
            "musher: wait is not running; offered by cf2x_0, cf2x_1\n");
}

TEST_F(SkillCommand, ReportsAPauseThatIsRefusedWithTheReason) {
  FakeSkills robot("cf2x_0");
  Process run({kMusher, "skill", "run", "deaf"});
  ASSERT_NE(run.LineWith("10 %  Skill deaf started"), "");
  const Ran ran = RunProgram({"skill", "pause", "deaf"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_EQ(ran.err, "musher: cf2x_0: deaf cannot be paused: it does not listen\n");
  robot.Finish();
  EXPECT_EQ(run.Wait().exit, 0);
}

TEST_F(SkillCommand, ReportsACancellationThatIsRejected) {
  FakeSkills robot("cf2x_0");
  Process run({kMusher, "skill", "run", "deaf"});
  ASSERT_NE(run.LineWith("10 %  Skill deaf started"), "");
  const Ran ran = RunProgram({"--json", "skill", "cancel", "deaf"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_EQ(Json(ran.out)["runs"][0]["outcome"], "running") << ran.out;
  EXPECT_EQ(ran.err, "musher: deaf of cf2x_0 has not ended yet: cf2x_0 refuses the cancellation\n");
  robot.Finish();
  EXPECT_EQ(run.Wait().exit, 0);
}

TEST_F(SkillCommand, FollowsEveryChangeUntilItIsInterrupted) {
  auto robot = std::make_unique<FakeSkills>("cf2x_0");
  Process text({kMusher, "skill", "watch", "rise"});
  Process json({kMusher, "--json", "skill", "watch"});
  msg::SkillFeedback feedback;
  feedback.skill = "rise";
  feedback.state = "RISING";
  feedback.progress = 20;
  feedback.message = "Rising";
  feedback.details = {{"height_m", "0.4"}, {"requested_by", "alice@desk"}};
  std::atomic<bool> seen = false;
  std::thread publisher([&] {
    while (!seen) {
      robot->Publish(feedback);
      std::this_thread::yield();
    }
  });
  EXPECT_THAT(text.LineWith("RISING"),
              HasSubstr("  RISING  Rising  height_m 0.4  requested_by alice@desk"));
  const auto line = Json(json.LineWith("RISING"));
  seen = true;
  publisher.join();
  EXPECT_EQ(line["status"], "processing");
  EXPECT_EQ(line["details"], Json(R"({"height_m":"0.4"})"));
  EXPECT_EQ(line["requested_by"], "alice@desk");
  robot.reset();
  EXPECT_NE(text.LineWith("cf2x_0 is lost"), "");
  text.Signal(SIGINT);
  EXPECT_EQ(text.Wait().exit, 0);
}

TEST_F(SkillCommand, DrawsASkill) {
  const FakeSkills robot("cf2x_0");
  EXPECT_EQ(RunProgram({"graph", "--skill", "rise"}).out, "dot of rise\n");
  EXPECT_EQ(
      RunProgram({"graph", "--skill", "rise", "--actuator", "cf2x_0", "--format", "mermaid"}).out,
      "mermaid of rise\n");
  EXPECT_EQ(RunProgram({"graph", "--skill", "rice"}).exit, 1);
  EXPECT_EQ(RunProgram({"graph", "--skill", "rise", "--behavior", "show"}).exit, 2);
  EXPECT_EQ(RunProgram({"graph", "--actuator", "cf2x_0"}).exit, 2);
}

TEST_F(SkillCommand, IsCompletedBySkillsActuatorsAndKeys) {
  const FakeSkills zero("cf2x_0");
  const FakeSkills one("cf2x_1");
  EXPECT_EQ(RunProgram({"complete", "skill", "run", "r"}).out,
            "refuse\t\nrise\trises to an altitude\n");
  EXPECT_EQ(RunProgram({"complete", "skill", "run", "rise", "a"}).out,
            "altitude=\ta number, default 1 (m above the ground)\n");
  EXPECT_EQ(RunProgram({"complete", "skill", "run", "rise", "altitude", "=", ""}).out, "");
  EXPECT_EQ(RunProgram({"complete", "skill", "run", "rise", "altitude", "=", "2", "t"}).out,
            "text=\ta text, default (what it says)\n");
  EXPECT_EQ(RunProgram({"complete", "skill", "run", "rise", "--actuator", ""}).out,
            "cf2x_0\t\ncf2x_1\t\n");
  EXPECT_EQ(RunProgram({"complete", "graph", "--skill", "wa"}).out, "wait\t\n");
}

}  // namespace musher::cli::skill_command_test
