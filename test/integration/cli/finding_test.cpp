// Finding a controller, or saying well that there is none.

#include <signal.h>

#include <chrono>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::finding_test {

using ::testing::HasSubstr;

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

TEST_F(Finding, RefusesADomainThatThereIsNot) {
  setenv("ROS_DOMAIN_ID", "300", 1);
  const Ended status = Musher({"status", "--json"});
  EXPECT_EQ(status.exit, 2);
  EXPECT_THAT(Json(status.out)["error"].get<std::string>(), HasSubstr("0 to 232"));
}

}  // namespace musher::testing::finding_test
