// Tests new_module with injected faults, in virtual time.

#include "new_module.hpp"

#include "musher/simulation/actuator_fault_test.hpp"

TEST(NewModule, HasPowerOnlyInActiveAndNeverInAnEmergencyStop) {
  musher::simulation::ActuatorFaultTest<NewModule> test;
  test.config_file = "robot.toml";
  test.always = [](const NewModule& new_module, const musher::ActuatorReport& report) {
    EXPECT_FALSE(report.state == "LowPower" && new_module.powered());
    EXPECT_FALSE(report.emergency_stop != 0 && new_module.powered());
  };
  test.after_emergency_stop = [](const NewModule& new_module, const musher::ActuatorReport&) {
    EXPECT_FALSE(new_module.powered());
  };
  test.Run();
}
