// An actuator that the systemd of another host runs: started, watched and ended from one config.

#include <gmock/gmock.h>

#include <chrono>

#include "musher/test/integration/hosts/robot_and_board.hpp"

namespace musher::testing::board_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using Board = RobotAndBoard;

std::size_t Count(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(Board, RunsTheActuatorAsAUnitUntilTheMachineIsTornDown) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t pid = PidOfEyes();
  EXPECT_EQ(Property("MainPID"), std::to_string(pid));
  EXPECT_EQ(Property("ActiveState"), "active");
  EXPECT_THAT(History(), HasSubstr("eyes started on host board (pid " + std::to_string(pid)));
  EXPECT_THAT(robot_->Run({"logs", "eyes", config_}).err, HasSubstr("journalctl -u musher-robot-"));

  const Ended down = robot_->Run({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, ReportsTheExitOfAProcessWithItsReasonAndItIsStartedAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  EXPECT_EQ(OnBoard({"kill", "-KILL", std::to_string(before)}).exit, 0);
  ASSERT_TRUE(Until([&] { return PidOfEyes() != before && PidOfEyes() != 0; }));
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
  EXPECT_THAT(History(),
              HasSubstr("eyes's process " + std::to_string(before) + " ended: killed by SIGKILL"));
  EXPECT_EQ(robot_->Run({"restart", "eyes"}).exit, 0);
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, KeepsItsProcessWhileTheLinkIsCutAndItIsFoundAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  Cut();
  ASSERT_TRUE(
      Until([this] { return History().find("What runs there runs on") != std::string::npos; },
            std::chrono::seconds(30)))
      << History();
  Heal();
  ASSERT_TRUE(Until([this] { return History().find("host board is reached") != std::string::npos; },
                    std::chrono::seconds(30)));
  ASSERT_TRUE(AwaitActive());
  EXPECT_EQ(PidOfEyes(), before);
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  EXPECT_EQ(Count(History(), "eyes started on host board"), 1U);
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, KeepsItsProcessWhenTheControllerIsKilledAndTheNextOneEndsIt) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  const pid_t before = PidOfEyes();
  const nlohmann::json status = robot_->Status();
  ASSERT_EQ(robot_->Do({"kill", "-KILL", std::to_string(status["pid"].get<int>())}).exit, 0);
  ASSERT_TRUE(Until([this] { return robot_->Status().is_null(); }));
  EXPECT_EQ(Property("MainPID"), std::to_string(before));
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(PidOfEyes(), before);
  ASSERT_TRUE(Until(
      [this] { return History().find("eyes runs on host board already") != std::string::npos; }));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, IsBootedAgainAndItsActuatorIsStartedAndDrivenAgain) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  PowerOff();
  Boot();
  ASSERT_TRUE(AwaitBoard());
  ASSERT_TRUE(Until([this] { return Count(History(), "eyes started on host board") == 2; },
                    std::chrono::seconds(60)))
      << History();
  ASSERT_TRUE(AwaitActive());
  EXPECT_THAT(History(), HasSubstr("has been booted again"));
  EXPECT_EQ(Property("MainPID"), std::to_string(PidOfEyes()));
}

TEST_F(Board, ThatIsOutOfReachIsNamedWhenTheMachineIsTornDown) {
  ASSERT_NO_FATAL_FAILURE(StartUp());
  Cut();
  const Time begin = std::chrono::steady_clock::now();
  const Ended down = robot_->Run({"down"});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(15));
  EXPECT_EQ(down.exit, 1);
  EXPECT_THAT(down.out + down.err, HasSubstr("eyes: host board is out of reach"));
  Heal();
  ASSERT_TRUE(AwaitBoard());
  // The next start finds what was left, and its end ends it.
  ASSERT_NO_FATAL_FAILURE(StartUp());
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, ThatRefusesTheKeyIsNamedWithWhatToDo) {
  ASSERT_EQ(OnBoard({"rm", "/root/.ssh/authorized_keys"}).exit, 0);
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(),
              AllOf(HasSubstr("host board (root@10.77.3.2)"), HasSubstr("Permission denied"),
                    HasSubstr("authorized_keys")));
  std::filesystem::copy_file(root_->Key() + ".pub", root_->path() + "/root/.ssh/authorized_keys");
}

TEST_F(Board, WithoutTheProgramSaysSo) {
  Replace(BinDir() + "/musher-exec\", \"" + (folder_ / "eyes"), "/opt/none\", \"x");
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(),
              AllOf(HasSubstr("/opt/none could not be executed there"),
                    HasSubstr("journalctl -u musher-robot-eyes.service")));
  EXPECT_EQ(robot_->Run({"down"}).exit, 0);
  EXPECT_THAT(Units(), IsEmpty());
}

TEST_F(Board, WithAUnitOfThatNameOfAnotherMachineIsNotTouched) {
  ASSERT_EQ(OnBoard({"systemd-run", "--unit=musher-robot-eyes", "sleep", "1000"}).exit, 0);
  const std::string before = Property("MainPID");
  const Ended up = Up();
  EXPECT_THAT(up.out + up.err + History(), HasSubstr("for another machine of this name"));
  robot_->Run({"down"});
  EXPECT_EQ(Property("MainPID"), before);
}

}  // namespace musher::testing::board_test
