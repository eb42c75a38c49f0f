#include "musher/modules/exec/state_runner.hpp"

#include <gmock/gmock.h>
#include <poll.h>

#include <csignal>
#include <fstream>
#include <string>

#include "musher/test/modules/exec/processes.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::exec::state_runner_test {

using ::testing::HasSubstr;

class StateRunnerTest : public ::testing::Test {
 protected:
  StateRunnerTest() {
    config_.module = 3000;
    config_.stop_time = std::chrono::seconds(20);
  }

  void On(const State& state, const std::string& line) {
    config_.states[state].run = {"sh", "-c", line};
  }
  void Start(const std::string& line) { config_.states["SetUp"].start = {"sh", "-c", line}; }

  Result<> Run(StateRunner& runner, const State& state) {
    return runner.Run(
        state, [] { return false; }, false);
  }
  Result<> Run(const State& state) {
    StateRunner runner("motion", config_, reaper_.value());
    return Run(runner, state);
  }

  std::string Content(const std::string& file) const {
    std::ifstream stream(folder_ / file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  const TempFolder folder_;
  const Result<Reaper> reaper_ = Reaper::Start();
  ExecConfig config_;
};

TEST_F(StateRunnerTest, SucceedsWithoutActions) {
  EXPECT_TRUE(Run("SetUp"));
  EXPECT_TRUE(Run("Active"));
  EXPECT_TRUE(Run("TearDown"));
}

TEST_F(StateRunnerTest, TreatsExitCodeZeroAsDone) {
  On("Active", "exit 0");
  EXPECT_TRUE(Run("Active"));
}

TEST_F(StateRunnerTest, MakesAnExitCodeCyberdogsCodeAndTheLastLineTheReason) {
  On("SelfCheck", "echo the motor board does not answer; exit 9");
  const auto result = Run("SelfCheck");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(),
            (Error{3009,
                   "exit code 9 of `echo the motor board does not answer; exit 9`; last output: "
                   "the motor board does not answer"}));
}

TEST_F(StateRunnerTest, ReportsTheExitCodeOfASilentCommand) {
  On("SelfCheck", "exit 9");
  EXPECT_EQ(Run("SelfCheck").error(), (Error{3009, "exit code 9 of `exit 9`"}));
}

TEST_F(StateRunnerTest, CallsAnExitCodeThatIsNoKeyFailed) {
  On("Active", "no-such-program");
  const auto result = Run("Active");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, 3001);
  EXPECT_THAT(result.error().message,
              HasSubstr("exit code 127 of `no-such-program`; last output: "));
}

TEST_F(StateRunnerTest, CallsACrashFailed) {
  On("Active", "echo hot; kill -SEGV $$");
  EXPECT_EQ(Run("Active").error(),
            (Error{3001, "killed by SIGSEGV of `echo hot; kill -SEGV $$`; last output: hot"}));
}

TEST_F(StateRunnerTest, PassesStateActuatorAndProgramToACommand) {
  Start("exec sleep infinity");
  On("Active", "echo $MUSHER_STATE $MUSHER_ACTUATOR > " + folder_ / "called" +
                   "; kill -0 $MUSHER_PROGRAM_PID");
  StateRunner runner("motion", config_, reaper_.value());
  ASSERT_TRUE(Run(runner, "SetUp"));
  EXPECT_TRUE(Run(runner, "Active"));
  EXPECT_EQ(Content("called"), "Active motion\n");
}

TEST_F(StateRunnerTest, PassesAnEngagedEmergencyStopToACommand) {
  On("Protected", "echo ${MUSHER_EMERGENCY_STOP:-none} >> " + folder_ / "called");
  StateRunner runner("motion", config_, reaper_.value());
  EXPECT_TRUE(runner.Run(
      "Protected", [] { return false; }, true));
  EXPECT_TRUE(Run(runner, "Protected"));
  EXPECT_EQ(Content("called"), "1\nnone\n");
}

TEST_F(StateRunnerTest, StopsACommandWhoseResultIsNoLongerNeeded) {
  On("Active", "echo $$ > " + folder_ / "ready" + "; exec sleep infinity");
  StateRunner runner("motion", config_, reaper_.value());
  const auto result = runner.Run(
      "Active", [this] { return ReadPid(folder_ / "ready") > 0; }, false);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, 3007);
  EXPECT_THAT(result.error().message,
              HasSubstr("` was stopped, because its result is no longer needed"));
}

TEST_F(StateRunnerTest, TreatsASuccessfulExitAsDoneEvenWhenStopped) {
  On("Active",
     "trap 'exit 0' TERM; echo $$ > " + folder_ / "ready" + "; while :; do sleep 0.01; done");
  StateRunner runner("motion", config_, reaper_.value());
  EXPECT_TRUE(runner.Run(
      "Active", [this] { return ReadPid(folder_ / "ready") > 0; }, false));
}

TEST_F(StateRunnerTest, StartsNoCommandAfterHurry) {
  On("Active", "touch " + folder_ / "begun");
  StateRunner runner("motion", config_, reaper_.value());
  runner.Hurry(Wanted::kNo);
  EXPECT_EQ(Run(runner, "Active").error().code, 3004);
  EXPECT_EQ(Content("begun"), "");
}

TEST_F(StateRunnerTest, KeepsTheProgramRunningUntilTearDown) {
  Start("echo $$ > " + folder_ / "program" + "; exec sleep infinity");
  StateRunner runner("motion", config_, reaper_.value());
  ASSERT_TRUE(Run(runner, "SetUp"));
  const pid_t program = ReadPid(folder_ / "program");
  ASSERT_TRUE(Run(runner, "Active"));
  EXPECT_EQ(kill(program, 0), 0);
  ASSERT_TRUE(Run(runner, "TearDown"));
  EXPECT_TRUE(HasExited(program));
  EXPECT_TRUE(runner.tearing_down());
}

TEST_F(StateRunnerTest, KillsAProgramThatIgnoresSigterm) {
  config_.stop_time = Milliseconds(50);
  Start("trap '' TERM; echo $$ > " + folder_ / "program" + "; while :; do sleep 1; done");
  StateRunner runner("motion", config_, reaper_.value());
  ASSERT_TRUE(Run(runner, "SetUp"));
  const pid_t program = ReadPid(folder_ / "program");
  ASSERT_GT(program, 0);
  EXPECT_TRUE(Run(runner, "TearDown"));
  EXPECT_EQ(runner.AwaitProgram()->Text(), "killed by SIGKILL");
  EXPECT_TRUE(HasExited(program));
}

TEST_F(StateRunnerTest, FailsSetUpWhenTheProgramCannotBeRun) {
  config_.states["SetUp"].start = {"/no/such/server"};
  const auto result = Run("SetUp");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, 3001);
  EXPECT_THAT(result.error().message, HasSubstr("can't run /no/such/server"));
}

TEST_F(StateRunnerTest, FailsSetUpAndEndsItsCommandWhenTheProgramEnds) {
  Start("exit 4");
  On("SetUp", "exec sleep infinity");
  const auto result = Run("SetUp");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), (Error{3001, "sh ended during SetUp: exit code 4"}));
}

TEST_F(StateRunnerTest, StopsTheProgramWhenSetUpFails) {
  Start("echo $$ > " + folder_ / "program" + "; exec sleep infinity");
  On("SetUp", "while [ ! -s " + folder_ / "program" + " ]; do sleep 0.01; done; exit 5");
  StateRunner runner("motion", config_, reaper_.value());
  EXPECT_EQ(Run(runner, "SetUp").error().code, 3005);
  EXPECT_TRUE(HasExited(ReadPid(folder_ / "program")));
}

TEST_F(StateRunnerTest, KeepsTheProgramWhenTearDownFails) {
  Start("echo $$ > " + folder_ / "program" + "; exec sleep infinity");
  On("TearDown", "exit 5");
  StateRunner runner("motion", config_, reaper_.value());
  ASSERT_TRUE(Run(runner, "SetUp"));
  EXPECT_EQ(Run(runner, "TearDown").error().code, 3005);
  EXPECT_FALSE(runner.tearing_down());
  EXPECT_EQ(kill(ReadPid(folder_ / "program"), 0), 0);
}

TEST_F(StateRunnerTest, DetectsThatTheProgramHasExited) {
  Start("exec sleep infinity");
  On("Active", "kill -KILL $MUSHER_PROGRAM_PID");
  StateRunner runner("motion", config_, reaper_.value());
  EXPECT_EQ(runner.program_watch(), -1);
  ASSERT_TRUE(Run(runner, "SetUp"));
  pollfd watch{runner.program_watch(), POLLIN, 0};
  EXPECT_EQ(poll(&watch, 1, 0), 0);
  ASSERT_TRUE(Run(runner, "Active"));
  EXPECT_EQ(poll(&watch, 1, 20'000), 1);
  EXPECT_EQ(runner.AwaitProgram()->Text(), "killed by SIGKILL");
}

}  // namespace musher::exec::state_runner_test
