// A command in another network namespace than the robot, on the same computer and with the same
// state folder: DDS and the names of processes do not reach there, pids and files do.

#include <fcntl.h>
#include <sched.h>
#include <signal.h>

#include <future>

#include "musher/base/unique_fd.hpp"
#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::other_network_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class OtherNetwork : public MachineByCli {
 protected:
  void SetUp() override {
    if (RunToEnd({"unshare", "--net", "true"}).exit != 0) {
      GTEST_SKIP() << "a network namespace needs root";
    }
    setenv("XDG_STATE_HOME", (folder_ / "xdg").c_str(), 1);  // commands find the files there
    Drop("state_dir = \"state\"\n");
    there_ = std::make_unique<Process>(std::vector<std::string>{
        "unshare", "--net", "sh", "-c", "echo ready; exec tail -f /dev/null"});
    ASSERT_NE(there_->LineWith("ready"), "");
    std::async(std::launch::async, [this] {
      const std::string path = "/proc/" + std::to_string(there_->pid()) + "/ns/net";
      const UniqueFd network(open(path.c_str(), O_RDONLY | O_CLOEXEC));
      ASSERT_EQ(setns(network.get(), CLONE_NEWNET), 0);
      fault_injection::BringUp("lo");
    }).get();
    ASSERT_EQ(UpDetached().exit, 0);
    before_ = AwaitStatus(AllHaveArrived);
    controller_ = before_["pid"];
  }
  void TearDown() override { unsetenv("XDG_STATE_HOME"); }

  static Ended In(pid_t network, std::vector<std::string> words) {
    words = Command(std::move(words));
    words.insert(words.begin(), {"nsenter", "--target", std::to_string(network), "--net", "--"});
    return RunToEnd(words);
  }
  Ended There(std::vector<std::string> words) const { return In(there_->pid(), std::move(words)); }
  static std::string Enter(pid_t pid) {
    return "`nsenter --target " + std::to_string(pid) + " --net musher ";
  }
  pid_t PidOf(const char* actuator) const { return before_["actuators"][actuator]["pid"]; }
  void KillTheController() const {
    kill(controller_, SIGKILL);
    waitpid(controller_, nullptr, 0);
  }

  std::unique_ptr<Process> there_;
  nlohmann::json before_;
  pid_t controller_ = 0;
};

TEST_F(OtherNetwork, ATakeoverThereLeavesTheControllerThatItCannotReach) {
  for (const bool stopped : {false, true}) {
    if (stopped) kill(controller_, SIGSTOP);
    const Ended taken = There({"up", config_, "--takeover", "--detach"});
    EXPECT_EQ(taken.exit, 2) << taken.out;
    EXPECT_THAT(taken.err, AllOf(HasSubstr("process " + std::to_string(controller_)),
                                 HasSubstr("another network namespace"),
                                 HasSubstr(Enter(controller_) + "up --takeover FILE`")));
  }
  kill(controller_, SIGCONT);
  EXPECT_EQ(Status(), before_);
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(OtherNetwork, AStartThereNamesTheNetworkAndNoTakeover) {
  for (const char* option : {"--detach", "--adopt"}) {
    const Ended start = There({"up", config_, option});
    EXPECT_EQ(start.exit, 2) << start.out;
    EXPECT_THAT(start.err, AllOf(HasSubstr("runs in another network namespace"),
                                 HasSubstr(Enter(controller_) + "status` shows it"),
                                 Not(HasSubstr("--takeover"))));
  }
  EXPECT_EQ(Status(), before_);
}

TEST_F(OtherNetwork, CommandsThereAreDoneByNoneAndNameTheController) {
  const std::string leads =
      "process " + std::to_string(controller_) + " leads robot in another network namespace";
  for (const std::vector<std::string>& words : {std::vector<std::string>{"status"},
                                                {"down"},
                                                {"down", "--without-controller"},
                                                {"estop", "smoke"},
                                                {"estop", "--release"},
                                                {"set", "LowPower"},
                                                {"restart", "legs"}}) {
    const Ended ended = There(words);
    SCOPED_TRACE(words[0]);
    EXPECT_EQ(ended.exit, 3) << ended.out;
    EXPECT_THAT(ended.err, AllOf(HasSubstr(leads), HasSubstr(Enter(controller_) + "COMMAND`"),
                                 Not(HasSubstr("`musher up FILE` starts one"))));
    if (words.back() == "smoke") End(PublisherOf(ended));
  }
  const Ended history = There({"history"});
  EXPECT_EQ(history.exit, 0);
  EXPECT_THAT(history.err, AllOf(HasSubstr(leads), Not(HasSubstr("without a record"))));
  EXPECT_THAT(There({"logs"}).err, HasSubstr(leads));
  EXPECT_THAT(There({"doctor"}).out, HasSubstr(leads));
  EXPECT_EQ(Status(), before_);
}

TEST_F(OtherNetwork, TheCommandThatARefusalNamesReachesTheRobot) {
  EXPECT_EQ(In(controller_, {"estop", "smoke"}).exit, 0);
  EXPECT_EQ(Status()["emergency_stop"]["reason"], "smoke");
}

// It led nothing: its actuators ran on where it did not receive them.
TEST_F(OtherNetwork, AStartThereLeavesActuatorsWhoseControllerHasCrashed) {
  KillTheController();
  const std::string legs = "legs (pid " + std::to_string(PidOf("legs")) + ")";
  const Ended down = There({"down", "--without-controller"});
  EXPECT_EQ(down.exit, 3) << down.out;
  EXPECT_THAT(down.err, AllOf(HasSubstr(legs), HasSubstr("run without a controller in another")));
  for (const char* option : {"--detach", "--takeover", "--adopt", "--restarted"}) {
    const Ended start = There({"up", config_, option});
    EXPECT_EQ(start.exit, 2) << start.out;
    EXPECT_THAT(start.err, AllOf(HasSubstr("another network namespace"), HasSubstr(legs),
                                 HasSubstr("up FILE` takes control of them")));
  }
  ASSERT_EQ(UpDetached().exit, 0);
  const auto after = AwaitStatus(AllHaveArrived);
  EXPECT_EQ(after["actuators"]["legs"]["pid"], PidOf("legs"));
  EXPECT_EQ(after["actuators"]["legs"]["state"], "Active");
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(OtherNetwork, AStartThereIsAnOrdinaryOneOnceTheRobotIsDown) {
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_TRUE(AwaitEnd(controller_));
  const Ended start = There({"up", config_, "--detach"});
  EXPECT_EQ(start.exit, 0) << start.err;
  EXPECT_EQ(There({"down"}).exit, 0);
}

}  // namespace musher::testing::other_network_test
