// What a person has set or torn down alone, and what becomes of it: by the policy, by a start of
// the others, over the end of its process and of the controller.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/next_controller.hpp"

namespace musher::testing::hold_test {

class AHold : public NextController {
 protected:
  static MachineConfig OursWithPolicy() {
    MachineConfig config = Ours(3);
    PolicyConfig& policy = config.policy.emplace();
    BatteryPolicy& battery = policy.battery.emplace();
    battery.tear_down_after = battery.raise_after = std::chrono::seconds(1);
    policy.low_power.emplace().motion_ids = {0, 101};
    return config;
  }
};

// A low battery brought the machine to the state in which b was held: the hold was forgotten, and
// the charged battery raised b with the others.
TEST_F(AHold, HeldInProtectedIsNotRaisedByTheBatteryThatIsChargedAgain) {
  Harness& t = Robot("Active", OursWithPolicy());
  ASSERT_TRUE(t.Set("Protected", "b").done());
  t.Rest();
  Battery(15);
  ASSERT_EQ(t.machine().state, "Protected");
  Battery(90, true);
  t.Rest();
  ASSERT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

// Likewise by a switch of the battery below the hold.
TEST_F(AHold, HeldBesideDancingIsNotLedToDancingByTheBattery) {
  Harness& t = Robot("Active", WithDancing(OursWithPolicy()));
  ASSERT_TRUE(t.Set("Dancing").done());
  ASSERT_TRUE(t.Set("Active", "b").done());
  Battery(15);
  ASSERT_EQ(t.machine().state, "Protected");
  Battery(90, true);
  t.Rest();
  ASSERT_EQ(t.machine().state, "Dancing");
  EXPECT_NE(t.StateOf("b"), "Dancing");
}

// The others were started again: the check of that start included the one that a person had put
// into Error, and ran its callback.
TEST_F(AHold, HeldInErrorIsNotLedOutByTheStartOfTheOthers) {
  Harness& t = Held(State(kError));
  t.Crash("a");
  t.Crash("c");
  CrashController(t);
  EXPECT_EQ(t.machine().state, "Active");
  EXPECT_EQ(t.StateOf("b"), "Error");
  for (const auto& one : t.log()) {
    if (one.starts_with("b:")) ADD_FAILURE() << one;
  }
}

// A person had checked it alone, and the status said "held", in SelfCheck: a crash raised it.
TEST_F(AHold, HeldInErrorAndCheckedAloneIsNotRaisedByACrashWhileTheStatusSaysHeld) {
  Harness& t = Held(State(kError));
  ASSERT_TRUE(t.Set("SelfCheck", "b").done());
  t.Rest();
  ASSERT_TRUE(t.RecordOf("b").held);
  t.Crash("b");
  t.Rest();
  EXPECT_NE(t.StateOf("b"), "Active");
}

// Likewise by the check of the machine.
TEST_F(AHold, HeldInErrorAndCheckedWithTheMachineFollowsOrIsHeldAlsoAfterACrash) {
  Harness& t = Held(State(kError));
  ASSERT_TRUE(t.Set("SelfCheck").done());
  t.Rest();
  const bool held = t.RecordOf("b").held;
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(held, t.StateOf("b") != "Active");
}

// The flow leads out of Error by SelfCheck only; the next controller left b out as unchecked.
TEST_F(AHold, HeldInErrorIsNotLedToActiveWithoutASelfCheck) {
  Harness& t = Held(State(kError));
  t.Set("Active");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Error");
}

// The charged battery raised the machine and left b in Error. With the next controller that was
// refused, since a critical b had not passed its self-check.
TEST_F(AHold, ACriticalOneHeldInErrorKeepsNoBatteryFromRaisingTheMachineAfterARestart) {
  for (const bool crash : {false, true}) {
    MachineConfig config = OursWithPolicy();
    ActuatorNamed(config, "b").critical = true;
    ActuatorNamed(config, "b").on_lost = "Protected";
    Harness& t = Robot("Active", config);
    ASSERT_TRUE(t.Set("Error", "b").done());
    t.Rest();
    Battery(15);
    ASSERT_EQ(t.machine().state, "Protected");
    if (crash) CrashController(t);
    Battery(90, true);
    t.Rest();
    EXPECT_EQ(t.StateOf("b"), "Error");
    EXPECT_EQ(t.machine().state, "Active") << "crash " << crash;
  }
}

// The controller and all processes are killed, as with their container: nothing was left to take
// over, and the robot never came up again.
TEST_F(AHold, ThoseThatNoPolicyRestartsComeUpWhereNothingRunsAnyMore) {
  MachineConfig config = Ours(3);
  for (ActuatorConfig& actuator : config.actuators) actuator.restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  for (const char* name : {"a", "b", "c"}) t.Crash(name);
  CrashController(t);
  EXPECT_EQ(t.machine().state, "Active");
  t.Crash("b");
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b"));
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b"));
}

// The controller crashes while b executes the TearDown that a person has requested of it alone.
TEST_F(AHold, ATearDownAloneThatTheControllerDidNotOutliveIsNotUndoneByTheNext) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "TearDown").takes = std::chrono::seconds(1);
  t.RequestSwitch("TearDown", "b");
  t.RunFor(Milliseconds(50));
  ASSERT_EQ(t.CoreOf("b").report.target, "TearDown");
  t.Crash("b");
  CrashController(t);
  EXPECT_FALSE(t.IsAlive("b"));
}

// Its TearDown was done and answered; its process takes long to exit, under the next controller.
TEST_F(AHold, TornDownAloneWhoseProcessEndsSlowlyIsNotNamedAsLostByTheNextController) {
  Harness& t = In("Active", Ours(3));
  t.shared.insert("b");
  ASSERT_TRUE(t.Set("TearDown", "b").done());
  t.Rest();
  ASSERT_TRUE(t.IsAlive("b"));
  bool ended = false;
  t.after_step = [&] {
    if (std::exchange(ended, true)) return;
    t.Exit("b", 0, "late");
  };
  t.RestartController(false, true);
  t.Rest();
  ASSERT_FALSE(t.IsAlive("b"));
  EXPECT_EQ(t.RecordOf("b").lost_in, "");
  const SwitchResult result = t.Set("TearDown");
  EXPECT_EQ(result.outcome, SwitchOutcome::kDone) << result.reason;
}

// The next controller took b over in the middle of that TearDown, and b crashed in it. Beside one
// controller it stayed down.
TEST_F(AHold, ATearDownAloneThatTheNextControllerFindsUnderWayIsNotUndoneByACrash) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "TearDown").takes = std::chrono::seconds(5);
  t.RequestSwitch("TearDown", "b");
  t.RunFor(Milliseconds(50));
  t.RestartController(false, true);
  t.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  t.Crash("b");
  t.Rest();
  EXPECT_FALSE(t.IsAlive("b"));
}

// Likewise on the way to the state in which a person holds it.
TEST_F(AHold, LedDownAloneAndLostUnderTheNextControllerIsNotRaised) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "LowPower").takes = std::chrono::seconds(5);
  t.RequestSwitch("LowPower", "b");
  t.RunFor(Milliseconds(50));
  t.RestartController(false, true);
  t.RunFor(std::chrono::seconds(1));
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  t.Crash("b");
  t.Rest();
  EXPECT_NE(t.StateOf("b"), "Active");
}

// Likewise where both end at once.
TEST_F(AHold, LedDownAloneAndLostWithTheControllerIsNotRaised) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "LowPower").takes = std::chrono::seconds(5);
  t.RequestSwitch("LowPower", "b");
  t.RunFor(Milliseconds(50));
  t.Crash("b");
  CrashController(t);
  EXPECT_NE(t.StateOf("b"), "Active");
}

}  // namespace musher::testing::hold_test
