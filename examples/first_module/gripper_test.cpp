// Tests the gripper with injected faults, in virtual time.

#include "gripper.hpp"

#include "musher/simulation/actuator_fault_test.hpp"

TEST(Gripper, HasPowerOnlyWhereItShould) {
  musher::simulation::ActuatorFaultTest<Gripper> test;
  test.config_file = "robot.toml";
  test.always = [](const Gripper& gripper, const musher::ActuatorReport& report) {
    EXPECT_FALSE(report.state == "LowPower" && gripper.powered());
    EXPECT_FALSE(report.emergency_stop != 0 && gripper.powered());
  };
  test.after_emergency_stop = [](const Gripper& gripper, const musher::ActuatorReport&) {
    EXPECT_FALSE(gripper.powered());
  };
  test.Run();
}
