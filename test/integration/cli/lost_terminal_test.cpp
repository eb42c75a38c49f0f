// `musher up` loses its terminal, or the program that reads its output: the machine keeps running.

#include <signal.h>

#include <cstdlib>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::lost_terminal_test {

using ::testing::HasSubstr;

class LostTerminal : public MachineByCli {
 protected:
  // The same controller leads the machine, and it obeys.
  static void ExpectLed(pid_t controller) {
    EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
    const Ended asked = Musher({"status", "--json"});
    ASSERT_EQ(asked.exit, 0) << asked.out << asked.err;
    const auto status = Json(asked.out);
    EXPECT_EQ(status["pid"], controller);
    EXPECT_EQ(status["state"], "LowPower");
  }
};

// musher up robot.toml | head -2
TEST_F(LostTerminal, AReaderOfTheOutputThatEndsDoesNotTakeTheControllerAlong) {
  for (const char* json : {"--color=never", "--json"}) {
    Process up(Command({"up", config_, json}));
    ASSERT_NE(up.LineWith("legs started (pid"), "");
    up.CloseOutput();
    const pid_t controller = AwaitStatus(AllHaveArrived)["pid"];
    ExpectLed(controller);
    EXPECT_TRUE(up.AwaitError(
        "its reader has exited; robot keeps running: Ctrl-C or `musher down` stops it"));
    up.Signal(SIGINT);
    EXPECT_EQ(up.Wait().exit, 0);
    EXPECT_TRUE(AwaitNoChildren());
  }
}

// musher status --follow | head -1: nothing happens that would be printed.
TEST_F(LostTerminal, ACommandThatFollowsEndsWithItsReaderAlsoWithoutAnEvent) {
  ASSERT_EQ(UpDetached().exit, 0);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"status", "--follow"}, {"logs", "-f", "controller"}}) {
    Process follows(Command(words));
    ASSERT_NE(follows.LineWith("Active"), "") << words.front();
    follows.CloseOutput();
    const Ended ended = follows.Wait();
    EXPECT_EQ(ended.exit, 0) << words.front() << ended.err;
  }
}

TEST_F(LostTerminal, ACommandWhoseOutputIsNotTakenByTheDiskFails) {
  const Ended ended =
      RunToEnd({"sh", "-c", "'" + BinDir() + "/musher' graph '" + config_ + "' > /dev/full"});
  EXPECT_EQ(ended.exit, 2);
  EXPECT_THAT(ended.err, HasSubstr("output lost: No space left on device"));
}

// musher up robot.toml | tee log, and Ctrl-C, which ends tee at once
TEST_F(LostTerminal, CtrlCTakesTheMachineDownAlsoWhereItEndsTheReaderOfTheOutput) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("eyes: Active done"), "");
  up.CloseOutput();
  up.Signal(SIGINT);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_TRUE(AwaitNoChildren());  // no actuator is left without a controller
}

TEST_F(LostTerminal, ATerminalThatClosesLeavesTheControllerAsDetachWouldHave) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("eyes: Active done"), "");
  const pid_t controller = AwaitStatus(AllHaveArrived)["pid"];
  up.CloseOutput();
  up.Signal(SIGHUP);
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.err,
              HasSubstr("the terminal is closed; the controller (pid " +
                        std::to_string(controller) + ") keeps running: `musher down` stops"));
  ExpectLed(controller);
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("the terminal of `musher up` is closed"));
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(LostTerminal, WhileTheMachineStartsItComesUpAllTheSame) {
  Blocks("legs", "SetUp");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("legs started (pid"), "");
  up.Signal(SIGHUP);
  EXPECT_EQ(up.Wait().exit, 0);
  Release();
  EXPECT_EQ(AwaitStatus(AllHaveArrived)["state"], "Active");
}

TEST_F(LostTerminal, AServiceHasNoTerminalToLose) {
  setenv("NOTIFY_SOCKET", "@musher-test-no-such-socket", 1);
  Process up(Command({"up", config_}));
  unsetenv("NOTIFY_SOCKET");
  ASSERT_NE(up.LineWith("eyes: Active done"), "");
  up.Signal(SIGHUP);
  EXPECT_TRUE(up.AwaitError("SIGHUP ignored: a service has no terminal; robot keeps running"));
  up.Signal(SIGINT);
  EXPECT_EQ(up.Wait().exit, 0);
}

}  // namespace musher::testing::lost_terminal_test
