// The gripper against drawn faults, in virtual time.

#include "gripper.hpp"

#include "musher/simulation/actuator_trial.hpp"

// [test]
TEST(Gripper, HasPowerOnlyWhereItShould) {
  musher::simulation::ActuatorTrial<Gripper> trial;
  trial.config_file = "robot.toml";
  trial.always = [](const Gripper& gripper, const musher::ActuatorReport& report) {
    EXPECT_FALSE(report.state == "LowPower" && gripper.powered());
    EXPECT_FALSE(report.emergency_stop != 0 && gripper.powered());
  };
  trial.after_emergency_stop = [](const Gripper& gripper, const musher::ActuatorReport&) {
    EXPECT_FALSE(gripper.powered());
  };
  trial.Run();
}
// [test end]
