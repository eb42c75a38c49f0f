// The controller crashes in the middle of a switch that a person waits for: `musher set` waited for
// 60 s and then reported that the next controller had not answered.

#include <signal.h>

#include <chrono>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::interrupted_switch_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

// `musher set` waited for 60 s.
constexpr auto kAtOnce = std::chrono::seconds(40);

class InterruptedSwitch : public MachineByCli {
 protected:
  // A callback that blocks is within its time on a slow computer, too.
  InterruptedSwitch() {
    Replace("times = [10000, 5000, 5000, 5000, 5000, 5000]",
            "times = [10000, 300000, 5000, 5000, 600000, 5000]");
    Replace("[controller]\n", "[controller]\nshutdown_budget_ms = 600000\n");
  }
  // `musher set LowPower`, which the legs do not come back from, and then no controller.
  void SetAndKillController() {
    Blocks("legs", "LowPower");
    ASSERT_EQ(UpDetached().exit, 0);
    set_ = std::make_unique<Process>(Command({"set", "LowPower"}));
    const auto status = AwaitStatus([](const auto& s) { return s["target"] == "LowPower"; });
    switch_ = "switch " + std::to_string(status["switch"].get<int>());
    controller_ = "pid " + std::to_string(status["pid"].get<pid_t>());
    ASSERT_EQ(Musher({"history"}).exit, 0);  // now the switch is on disk
    killed_ = Clock::now();
    kill(status["pid"].get<pid_t>(), SIGKILL);
  }

  std::unique_ptr<Process> set_;
  std::string switch_;
  std::string controller_;
  Clock::time_point killed_;
};

TEST_F(InterruptedSwitch, IsReportedAtOnceAndTheSuccessorReportsTheMachinesState) {
  ASSERT_NO_FATAL_FAILURE(SetAndKillController());
  ASSERT_TRUE(set_->AwaitError("the controller (" + controller_ + ", epoch 1) has exited during " +
                               switch_ + " to LowPower"));
  EXPECT_LT(Clock::now() - killed_, kAtOnce);
  EXPECT_EQ(Musher({"up", config_, "--detach"}).exit, 0);
  const Ended set = set_->Wait();
  EXPECT_EQ(set.exit, 1) << set.err;
  EXPECT_THAT(set.out, AllOf(HasSubstr("interrupted"), HasSubstr("LowPower")));
  EXPECT_THAT(set.err,
              HasSubstr("the controller of epoch 2 continues with the machine in LowPower"));
  Release();
}

TEST_F(InterruptedSwitch, ExitsWithFiveAndPrintsWhatToDoWithoutASuccessor) {
  ASSERT_NO_FATAL_FAILURE(SetAndKillController());
  const Ended set = set_->Wait();
  EXPECT_EQ(set.exit, 5);
  EXPECT_THAT(set.err, AllOf(HasSubstr("no successor within 6 s"), HasSubstr("musher up")));
  EXPECT_LT(Clock::now() - killed_, kAtOnce);
  Release();
}

// Its request went by the controller's socket, which is closed by the exit.
TEST_F(InterruptedSwitch, ATearDownIsContinuedByTheSuccessorOfTheControllerThatWasCalled) {
  Blocks("legs", "TearDown");
  ASSERT_EQ(UpDetached().exit, 0);
  Process down(Command({"down"}));
  const auto status = AwaitStatus([](const auto& s) { return s["target"] == "TearDown"; });
  const std::string pid = std::to_string(status["pid"].get<pid_t>());
  kill(status["pid"].get<pid_t>(), SIGKILL);
  ASSERT_TRUE(down.AwaitError("the controller (pid " + pid + ", epoch 1) has exited"));
  Process next(Command({"up", config_}));
  // Its TearDown may be over before it is looked at: legs that it does not know yet are signalled.
  AwaitStatus([](const auto& s) {
    return s["epoch"] == 2 && (s["target"] == "TearDown" || s["state"] == "TearDown");
  });
  Release();
  const Ended ended = down.Wait();
  // The legs may have exited before the successor could ask them for the end of their TearDown.
  EXPECT_LE(ended.exit, 1) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("the machine is in TearDown"));
  next.Wait();
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(InterruptedSwitch, ATearDownExitsWithFiveAndPrintsWhatToDoWithoutASuccessor) {
  Blocks("legs", "TearDown");
  ASSERT_EQ(UpDetached().exit, 0);
  Process down(Command({"down"}));
  const auto status = AwaitStatus([](const auto& s) { return s["target"] == "TearDown"; });
  kill(status["pid"].get<pid_t>(), SIGKILL);
  const Ended ended = down.Wait();
  EXPECT_EQ(ended.exit, 5);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("no successor within 6 s"), HasSubstr("musher up")));
  Release();
}

// It was refused as busy while the actuator of stage 2 was on its way.
TEST_F(InterruptedSwitch, UpRightAfterADetachedStartWaitsForTheLateActuator) {
  Does("eyes", "[state.LowPower]\nshell = \"sleep 0.3\"\n");
  ASSERT_EQ(Musher({"up", config_, "--detach"}).exit, 0);
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  const Ended up = Musher({"set", "Active"});
  EXPECT_EQ(up.exit, 0) << up.err;
}

}  // namespace musher::testing::interrupted_switch_test
