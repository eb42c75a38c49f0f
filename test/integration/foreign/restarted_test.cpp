// A ROS 2 node that crashes, is restarted by hand or hangs: it comes back, and gets SIGTERM before
// SIGKILL.

#include "musher/test/integration/foreign/mixed_machine.hpp"

namespace musher::testing::restarted_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

class Restarted : public MixedMachine {
 protected:
  void Start() {
    const Ended up = UpDetached();
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
  }
  static auto AwaitBack() { return AwaitStatus(AllHaveArrived); }
};

// The killed process stays matched for the 10 s of its lease.
TEST_F(Restarted, ByHandSoonAfterACrashTheNodeComesBackAndStays) {
  ASSERT_NO_FATAL_FAILURE(Start());
  kill(Started("planner").back(), SIGKILL);
  AwaitStatus([](const nlohmann::json& status) {
    return AllHaveArrived(status) && status["actuators"]["planner"]["restarts"] == 1;
  });
  for (int again = 0; again < 2; ++again) {
    const Ended restart = Musher({"restart", "planner"});
    EXPECT_EQ(restart.exit, 0) << restart.out << restart.err;
  }
  EXPECT_THAT(Started("planner"), SizeIs(4));
  const auto status = AwaitBack();
  EXPECT_EQ(status["actuators"]["planner"]["degraded"], false) << status;
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(Actuator("planner")["pid"], Started("planner").back());
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(Restarted, ByHandAHealthyNodeGetsSigtermAfterItsTearDownAndNoSigkill) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended restart = Musher({"restart", "planner"});
  EXPECT_EQ(restart.exit, 0) << restart.out << restart.err;
  EXPECT_THAT(Events("planner"), Contains("SIGTERM"));
  EXPECT_THAT(Musher({"history"}).out, Not(HasSubstr("SIGKILL")));
}

TEST_F(Restarted, ByItsPolicyAStoppedNodeIsDetectedWithinItsCheckpoint) {
  Config("planner", "checkpoint_ms = 1500\n");
  ASSERT_NO_FATAL_FAILURE(Start());
  const pid_t before = Started("planner").back();
  kill(before, SIGSTOP);
  AwaitStatus([&](const nlohmann::json& status) {
    return AllHaveArrived(status) && status["actuators"]["planner"]["restarts"] == 1;
  });
  EXPECT_FALSE(Runs(before));
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("hung: its process is stopped"));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(Restarted, NotWhileATransitionRunsForLongerThanItsCheckpoint) {
  Config("planner", "checkpoint_ms = 1000\n");
  Peer("planner", "takes=deactivate:3000");
  ASSERT_NO_FATAL_FAILURE(Start());
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0) << "a transition has its own time";
  EXPECT_THAT(Started("planner"), SizeIs(1));
  EXPECT_THAT(Musher({"history"}).out, Not(HasSubstr("hung")));
}

}  // namespace musher::testing::restarted_test
