// Finding a controller, or saying well that there is none.

#include <signal.h>

#include <chrono>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::finding_test {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Finding : public MachineByCli {};

TEST_F(Finding, EndsWithThreeWhereThereIsNoController) {
  const std::vector<std::vector<std::string>> commands = {{"status"},        {"status", "--follow"},
                                                          {"set", "Active"}, {"plan", "Active"},
                                                          {"history"},       {"down"}};
  for (std::vector<std::string> command : commands) {
    command.insert(command.end(), {"--timeout", "0.2"});
    const Ended ended = Musher(command);
    EXPECT_EQ(ended.exit, 3) << command[0];
    EXPECT_EQ(ended.out, "") << command[0];
    EXPECT_THAT(ended.err, HasSubstr("no controller in namespace '" + name_space_ + "'"));
  }
}

TEST_F(Finding, ReportsAMissingControllerInJson) {
  const Ended status = Musher({"status", "--json", "--timeout", "0.2"});
  EXPECT_EQ(status.exit, 3);
  EXPECT_EQ(Json(status.out)["code"], 105);
}

TEST_F(Finding, NamesTheControllersOfOtherNamespaces) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended status = Musher({"status", "--namespace", ""});
  EXPECT_EQ(status.exit, 3);
  EXPECT_THAT(status.err, HasSubstr("no controller in the default namespace; found '" +
                                    name_space_ + "' (robot) - use --namespace " + name_space_));
  unsetenv("MUSHER_NAMESPACE");
  EXPECT_EQ(Musher({"status", "--namespace", name_space_}).exit, 0);
}

// The table listed the actuators of the machine that ran, as if they had no controller.
TEST_F(Finding, NamesTheMachineThatRunsWhereAnotherOneIsMeantAndShowsItsActuatorsForNoOther) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended status = Musher({"status", "--machine", "nope"});
  EXPECT_EQ(status.exit, 3);
  EXPECT_EQ(status.out, "");
  EXPECT_THAT(status.err, HasSubstr("no controller of machine nope in namespace '" + name_space_ +
                                    "'; found '" + name_space_ + "' (robot)"));
  const Ended json = Musher({"status", "--machine", "nope", "--json"});
  EXPECT_EQ(json.exit, 3);
  EXPECT_THAT(json.out, Not(HasSubstr("legs")));
  // "`musher up FILE` starts one".
  const pid_t controller = Status()["pid"];
  kill(controller, SIGSTOP);
  const Ended silent = Musher({"status", "--machine", "nope"});
  kill(controller, SIGCONT);
  EXPECT_EQ(silent.exit, 3);
  EXPECT_EQ(silent.out, "");
  EXPECT_THAT(silent.err, AllOf(HasSubstr("robot"),
                                HasSubstr("leads here (pid " + std::to_string(controller) +
                                          "), and does not answer"),
                                Not(HasSubstr("`musher up FILE` starts one"))));
}

TEST_F(Finding, ShowsTheStatusForPeopleAndForPrograms) {
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended text = Musher({"status"});
  EXPECT_THAT(text.out, HasSubstr("robot  Active"));
  EXPECT_THAT(text.out, HasSubstr("legs*"));
  EXPECT_THAT(text.out, Not(HasSubstr("\x1b")));  // no colour in a pipe
  EXPECT_THAT(Musher({"status", "--color", "always"}).out, HasSubstr("\x1b[32mActive"));
  const auto status = Status();
  EXPECT_EQ(status["machine"], "robot");
  EXPECT_EQ(status["namespace"], name_space_);
  EXPECT_EQ(status["config"], config_);
  EXPECT_EQ(status["actuators"]["legs"]["state"], "Active");
  EXPECT_GT(status["actuators"]["legs"]["pid"], 0);
}

TEST_F(Finding, FollowsEveryChangeUntilCtrlC) {
  ASSERT_EQ(UpDetached().exit, 0);
  Process lines(Command({"status", "--follow"}));
  Process json(Command({"status", "--follow", "--json"}));
  ASSERT_NE(lines.LineWith("robot  Active"), "");
  ASSERT_NE(json.LineWith(R"("state":"Active")"), "");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_NE(lines.LineWith("robot  LowPower"), "");
  EXPECT_NE(json.LineWith(R"("state":"LowPower")"), "");
  ASSERT_EQ(Musher({"down"}).exit, 0);
  EXPECT_NE(lines.LineWith("controller lost"), "");
  EXPECT_NE(json.LineWith(R"("error":"controller lost")"), "");
  lines.Signal(SIGINT);
  EXPECT_EQ(lines.Wait().exit, 0);
}

// It showed the last status for up to 12 s, until DDS had given the controller up.
TEST_F(Finding, FollowsAControllerThatIsKilledAtOnce) {
  ASSERT_EQ(UpDetached().exit, 0);
  const auto controller = Status()["pid"].get<pid_t>();
  Process lines(Command({"status", "--follow"}));
  ASSERT_NE(lines.LineWith("robot  Active"), "");
  const auto killed = std::chrono::steady_clock::now();
  kill(controller, SIGKILL);
  EXPECT_NE(lines.LineWith("controller lost"), "");
  EXPECT_LT(std::chrono::steady_clock::now() - killed, std::chrono::seconds(9));
}

TEST_F(Finding, ShowsSinceWhenTheMachineIsInItsState) {
  ASSERT_EQ(UpDetached().exit, 0);
  const auto now = [] { return Json(Musher({"status", "--json"}).out); };
  auto first = now();
  ASSERT_TRUE(first["since"].is_string()) << first;
  EXPECT_GE(first["uptime_s"], 0);
  EXPECT_THAT(Musher({"status"}).out, ContainsRegex("robot  Active .*up "));
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_GT(now()["since"].get<std::string>(), first["since"].get<std::string>());
}

TEST_F(Finding, ShowsOnlyTheActuatorsThatFailed) {
  const std::string voice = "command = [\"musher-exec\", \"" + (folder_ / "voice");
  Replace(voice, "restart = \"no\"\n" + voice);
  ASSERT_EQ(UpDetached().exit, 0);
  const auto failed = [] {
    return Json(Musher({"status", "--failed", "--json"}).out)["actuators"];
  };
  EXPECT_THAT(failed(), IsEmpty());
  kill(Status()["actuators"]["voice"]["pid"].get<pid_t>(), SIGKILL);
  AwaitStatus([](const auto& status) { return status["actuators"]["voice"]["degraded"] == true; });
  const auto actuators = failed();
  EXPECT_EQ(actuators.size(), 1U) << actuators;
  EXPECT_TRUE(actuators.contains("voice"));
  const std::string text = Musher({"status", "--failed"}).out;
  EXPECT_THAT(text, AllOf(HasSubstr("voice"), Not(HasSubstr("legs")), Not(HasSubstr("eyes"))));
}

TEST_F(Finding, RefusesADomainThatThereIsNot) {
  setenv("ROS_DOMAIN_ID", "300", 1);
  const Ended status = Musher({"status", "--json"});
  EXPECT_EQ(status.exit, 2);
  EXPECT_THAT(Json(status.out)["error"].get<std::string>(), HasSubstr("0 to 232"));
}

}  // namespace musher::testing::finding_test
