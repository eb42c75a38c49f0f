// Two actuators in one process, which the controller has started for one of them.

#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::shared_process_test {

using ::testing::HasSubstr;

class SharedProcess : public MachineByCli {
 protected:
  SharedProcess() {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"])";
    std::ofstream file(config_);
    file << "[controller]\nname = \"robot\"\nactuators = [\"arm\", \"leg\"]\nstates = " << states
         << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace = \""
         << name_space_ << "\"\nstate_dir = \"state\"\n";
    for (const char* actuator : {"arm", "leg"}) {
      file << "[actuator." << actuator << "]\nstates = " << states
           << "\ntimes = [10000, 5000, 5000, 5000, 5000]\n";
      if (actuator == std::string("arm")) {
        file << "command = [\"" << BinDir() << "/cli_shared_process\"]\n";
      }
    }
  }

  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("the machine is Active"), "");
    pid_ = BothAre("Active")["actuators"]["arm"]["pid"];
  }
  // The status once both are in that state, in one process that is not `not_in`.
  static nlohmann::json BothAre(const std::string& state, int not_in = 0) {
    return AwaitStatus([&](const nlohmann::json& status) {
      const auto& arm = status["actuators"]["arm"];
      const auto& leg = status["actuators"]["leg"];
      const bool well = arm["degraded"] == false && leg["degraded"] == false;
      return well && arm["state"] == state && leg["state"] == state && arm["pid"] == leg["pid"] &&
             arm["pid"] != not_in && arm["pid"] != 0;
    });
  }

  std::unique_ptr<Process> up_;
  int pid_ = 0;
};

// The end of the second was seen by its silence: its process was watched for the first already.
TEST_F(SharedProcess, ItsEndIsSeenAtOnceForBoth) {
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(pid_, SIGKILL);
  EXPECT_THAT(up_->LineWith("arm is degraded"), HasSubstr("crashed: its process"));
  EXPECT_THAT(
      up_->LineWith("leg is degraded"),
      HasSubstr("crashed: its process " + std::to_string(pid_) + " ended: killed by SIGKILL"));
  BothAre("Active", pid_);
}

TEST_F(SharedProcess, IsRestartedWholeByARestartOfTheActuatorThatItWasStartedFor) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended restart = Musher({"restart", "arm"});
  EXPECT_EQ(restart.exit, 0) << restart.err;
  BothAre("Active", pid_);
}

TEST_F(SharedProcess, IsNotRestartedForAnActuatorThatOnlyRunsInIt) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended restart = Musher({"restart", "leg"});
  EXPECT_EQ(restart.exit, 1);
  EXPECT_THAT(restart.err, HasSubstr("leg has no command in the config"));
  EXPECT_EQ(BothAre("Active")["actuators"]["leg"]["pid"], pid_);
}

// SIGTERM came before the second one had its TearDown.
TEST_F(SharedProcess, EndsAfterTheTearDownOfItsSecondActuatorWhereTheFirstWasTornDownAlone) {
  ASSERT_NO_FATAL_FAILURE(Start());
  EXPECT_EQ(Musher({"set", "TearDown", "arm"}).exit, 0);
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_THAT(up_->LineWith("arm's process"), HasSubstr("ended: exit code 0"));
}

TEST_F(SharedProcess, EndsWithTheMachine) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_NE(kill(pid_, 0), 0);
}

}  // namespace musher::testing::shared_process_test
