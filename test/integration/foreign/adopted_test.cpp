// A controller is killed, or another one takes over: the next controller finds the processes that
// were started for a ROS 2 node and a CyberDog module. None runs twice, none is left over.

#include "musher/test/integration/foreign/mixed_machine.hpp"

namespace musher::testing::adopted_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class Adopted : public MixedMachine {
 protected:
  void Start() {
    const Ended up = UpDetached();
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
    for (const char* actuator : {"planner", "arm"}) {
      pids_.push_back(Started(actuator).back());
    }
  }
  // Both actuators still have their first process, and no other.
  void ExpectTheSameProcesses() const {
    EXPECT_THAT(Started("planner"), ElementsAre(pids_[0]));
    EXPECT_THAT(Started("arm"), ElementsAre(pids_[1]));
    for (const pid_t pid : pids_) EXPECT_TRUE(Runs(pid)) << pid;
  }
  void RemoveTheArm() const {
    std::string toml = ReadFile(config_);
    toml.replace(toml.find("[\"planner\", \"arm\"]"), 18, "[\"planner\"]");
    toml.erase(toml.find("[actuator.arm]"));
    std::ofstream(config_) << toml;
  }
  void ExpectDownEndsAll() const {
    const Ended down = Musher({"down"});
    EXPECT_EQ(down.exit, 0) << down.out << down.err;
    for (const char* actuator : {"planner", "arm"}) {
      for (const pid_t pid : Started(actuator)) EXPECT_FALSE(Runs(pid)) << actuator << " " << pid;
    }
  }

  std::vector<pid_t> pids_;
};

TEST_F(Adopted, ByTheControllerAfterAKilledOne) {
  ASSERT_NO_FATAL_FAILURE(Start());
  KillController();
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  ExpectTheSameProcesses();
  ExpectDownEndsAll();
}

TEST_F(Adopted, ByAControllerThatTakesOverAlsoFromAnotherFolder) {
  ASSERT_NO_FATAL_FAILURE(Start());
  for (const bool other_folder : {false, true}) {
    if (other_folder) Replace("state_dir = \"state\"", "state_dir = \"other\"");
    const Ended up = Musher({"up", config_, "--takeover", "--detach"});
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
    AwaitStatus(AllHaveArrived);
    ExpectTheSameProcesses();
  }
  ExpectDownEndsAll();
}

TEST_F(Adopted, WithTheShellsThatStartedThem) {
  WrapInShell();
  ASSERT_NO_FATAL_FAILURE(Start());
  KillController();
  ASSERT_EQ(UpDetached().exit, 0);
  ExpectTheSameProcesses();
  ExpectDownEndsAll();
}

TEST_F(Adopted, ThoughTheListOfProcessesWasNeverSaved) {
  ASSERT_NO_FATAL_FAILURE(Start());
  KillController();
  std::filesystem::remove(folder_ / "state/processes");
  ASSERT_EQ(UpDetached().exit, 0);
  ExpectTheSameProcesses();
  ExpectDownEndsAll();
}

TEST_F(Adopted, AndRestartedAtOnceWhenTheyExit) {
  ASSERT_NO_FATAL_FAILURE(Start());
  KillController();
  ASSERT_EQ(UpDetached().exit, 0);
  kill(pids_[0], SIGKILL);
  const auto back = AwaitStatus([&](const nlohmann::json& status) {
    return AllHaveArrived(status) && status["actuators"]["planner"]["restarts"] == 1;
  });
  EXPECT_THAT(Started("planner"), SizeIs(2));
  EXPECT_EQ(back["actuators"]["planner"]["pid"], Started("planner").back());
  ExpectDownEndsAll();
}

TEST_F(Adopted, UnlessTheShellHasExitedThenItsRemainsAreKilledBeforeTheNextStart) {
  WrapInShell();
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t shell = Actuator("planner")["pid"];
  ASSERT_NE(shell, pids_[0]);
  KillController();
  kill(shell, SIGKILL);
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_FALSE(Runs(pids_[0]));
  EXPECT_THAT(Started("planner"), SizeIs(2));
  ExpectDownEndsAll();
}

TEST_F(Adopted, UnlessTheConfigDoesNotListThemThenTheyAreStopped) {
  ASSERT_NO_FATAL_FAILURE(Start());
  KillController();
  RemoveTheArm();
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_TRUE(AwaitEnd(pids_[1]));
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("arm (pid " + std::to_string(pids_[1]) +
                                                 ") was started by an earlier controller, and "));
  ExpectDownEndsAll();
}

// The list of processes is in the folder of the controller that is replaced.
TEST_F(Adopted, ByATakeoverFromAnotherFolderWhichStopsTheOneThatItDoesNotList) {
  ASSERT_NO_FATAL_FAILURE(Start());
  RemoveTheArm();
  Replace("state_dir = \"state\"", "state_dir = \"other\"");
  const Ended up = Musher({"up", config_, "--takeover", "--detach"});
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  EXPECT_TRUE(AwaitEnd(pids_[1]));
  EXPECT_THAT(Started("planner"), ElementsAre(pids_[0]));
  ExpectDownEndsAll();
}

TEST_F(Adopted, OrStoppedWithoutAController) {
  ASSERT_NO_FATAL_FAILURE(Start());
  KillController();
  const Ended status = Musher({"status"});
  EXPECT_THAT(status.err, HasSubstr("planner (pid " + std::to_string(pids_[0]) + ")"));
  const Ended down = Musher({"down", "--without-controller"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
  for (const pid_t pid : pids_) EXPECT_FALSE(Runs(pid)) << pid;
}

}  // namespace musher::testing::adopted_test
