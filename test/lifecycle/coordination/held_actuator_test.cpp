// An actuator that a person has set alone stays there: nothing but a switch of the machine up, or a
// switch of its own, raises it.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::held_actuator_test {

using ::testing::IsEmpty;

class HeldActuators : public Switching {
 protected:
  // B of an Active machine is held in LowPower.
  Harness& InLowPower(MachineConfig config = Ours(3)) {
    Harness& t = In("Active", std::move(config));
    EXPECT_TRUE(t.Set("LowPower", "b").done());
    t.Rest();  // until it is on disk
    t.ClearLog();
    return t;
  }
  static void ExpectHeld(const Harness& t, const State& machine) {
    EXPECT_EQ(t.machine().state, machine);
    EXPECT_EQ(t.StateOf("b"), "LowPower");
    EXPECT_TRUE(t.RecordOf("b").held);
    EXPECT_FALSE(t.RecordOf("b").fault);
    EXPECT_TRUE(t.CoreOf("b").report.detached) << "the next controller has to know";
  }
};

TEST_F(HeldActuators, ARestartOfTheProcessAfterACrashRaisesNone) {
  Harness& t = InLowPower();
  t.Crash("b");
  t.Rest();
  ExpectHeld(t, "Active");
  t.RestartController(false, true);
  t.Rest();
  ExpectHeld(t, "Active");
}

// Its process ends together with the controller, as where a supervisor stops both.
TEST_F(HeldActuators, ARestartOfTheControllerAndOfTheProcessRaisesNone) {
  Harness& t = InLowPower();
  t.Crash("b");
  t.RestartController(false, true);
  t.Rest();
  ExpectHeld(t, "Active");
}

TEST_F(HeldActuators, AStartOfAPersonAfterATearDownRaisesThem) {
  Harness& t = InLowPower();
  ASSERT_TRUE(t.Set("TearDown").done());
  t.Rest();
  t.RestartController();
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(HeldActuators, ARestartThatAPersonRequestsRaisesNone) {
  Harness& t = InLowPower();
  const RequestId call = t.Restart("b");
  t.Rest();
  EXPECT_TRUE(t.calls.at(call));
  ExpectHeld(t, "Active");
}

TEST_F(HeldActuators, ASwitchOfTheMachineDownRaisesNone) {
  Harness& t = InLowPower();
  EXPECT_EQ(t.Set("Protected").outcome, SwitchOutcome::kDone);
  ExpectHeld(t, "Protected");
}

TEST_F(HeldActuators, TheFallbackAfterALossRaisesNone) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "c").critical = true;
  ActuatorNamed(config, "c").on_lost = "Protected";
  ActuatorNamed(config, "c").restart.policy = RestartPolicy::kNo;
  Harness& t = InLowPower(config);
  t.Crash("c");
  t.Rest();
  ExpectHeld(t, "Protected");
}

TEST_F(HeldActuators, ASwitchDownToItsStateAttachesIt) {
  Harness& t = InLowPower();
  EXPECT_TRUE(t.Set("LowPower").done());
  EXPECT_FALSE(t.RecordOf("b").held);
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(HeldActuators, ASwitchOfTheMachineUpRaisesThem) {
  Harness& t = InLowPower();
  ASSERT_TRUE(t.Set("Protected").done());
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
  EXPECT_FALSE(t.RecordOf("b").held);
  t.Crash("b");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "Active") << "it is held no more";
}

TEST_F(HeldActuators, TheRequestForTheStateOfTheMachineRaisesThem) {
  Harness& t = InLowPower();
  EXPECT_TRUE(t.Set("Active").done());
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(HeldActuators, ThatAreRestartedGoDownWithTheMachine) {
  Harness& t = In("Active", Ours(3));
  ASSERT_TRUE(t.Set("DeActive", "b").done());
  t.Crash("b");
  t.RunFor(Milliseconds(1));
  EXPECT_TRUE(t.RunUntil([&] { return t.RecordOf("b").presence != Presence::kPresent; }));
  t.Set("LowPower");
  t.Rest();
  EXPECT_EQ(t.StateOf("b"), "LowPower");
}

}  // namespace musher::testing::held_actuator_test
