// Tests the gripper with injected faults, in virtual time.

#include "gripper.hpp"

#include "musher/simulation/actuator_fault_test.hpp"

TEST(Gripper, IsOpenInProtectedAndHasNoPowerInLowPower) {
  musher::simulation::ActuatorFaultTest<Gripper> test;
  test.config_file = "robot.toml";
  test.make = [] {  // its jaw needs no time, since waiting takes real time here
    return std::make_unique<Gripper>(GripperConfig{.speed_mm_s = 1e12});
  };
  test.always = [](const Gripper& gripper, const musher::ActuatorReport& report) {
    EXPECT_FALSE(report.state == "LowPower" && gripper.powered());
    EXPECT_FALSE(report.state == "Protected" && gripper.width_mm() < 80);
  };
  test.after_emergency_stop = [](const Gripper& gripper, const musher::ActuatorReport&) {
    EXPECT_FALSE(gripper.moves());
  };
  test.Run();
}

TEST(Jaw, IsHalfwayAfterHalfTheTimeAndStaysWhereItIsHalted) {
  const musher::Time start{};
  Jaw jaw(80, 40);
  jaw.MoveTo(0, start);
  EXPECT_DOUBLE_EQ(jaw.WidthAt(start + musher::Milliseconds(1000)), 40);
  jaw.Halt(start + musher::Milliseconds(1500));
  EXPECT_DOUBLE_EQ(jaw.WidthAt(start + musher::Milliseconds(9000)), 20);
  EXPECT_FALSE(jaw.MovesAt(start + musher::Milliseconds(9000)));
}
