// What an actuator under test allows in each state.

#include <gtest/gtest-spi.h>

#include <map>

#include "musher/simulation/actuator_fault_test.hpp"

namespace musher::testing::gated_fault_test_test {

class Spinner : public MachineActuator {
 public:
  Spinner() : MachineActuator("motor") {
    for (const BuiltInState state : {kSetUp, kSelfCheck, kActive, kLowPower, kTearDown}) {
      RegisterStateCallback(state, [] { return kCodeOk; });
    }
  }

  Result<> Spin() const { return Allowed("spin", ModuleCode{3000}); }
};

struct SpinnerFaultTest : simulation::ActuatorFaultTest<Spinner> {
  int allowed = 0;
  std::map<State, int> refused;

  SpinnerFaultTest() {
    scenarios = 100;
    config_text = R"(
      [controller]
      actuators = ["motor"]
      states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
      default_time = 1000
      default_state = "Uninitialized"
      [actuator.motor]
      states = ["SetUp", "SelfCheck", "Active", "LowPower", "TearDown"]
      times = [1000, 1000, 1000, 1000, 1000]
      command = ["motor"]
      critical = true
      [capability.spin]
      actuators = ["motor"]
      min_battery = 40
    )";
    always = [this](const Spinner& motor, const ActuatorReport& report) {
      const Result<> spin = motor.Spin();
      const bool may = report.state == kActive && !report.busy() && report.emergency_stop == 0 &&
                       !report.held_by_stop;
      EXPECT_EQ(spin.ok(), may) << report.state << " " << report.target;
      if (spin.ok()) return void(++allowed);
      EXPECT_EQ(spin.error().code, 3003);
      ++refused[report.state];
    };
  }
};

TEST(GatedFaultTest, AllowsWhatTheConfigAllowsInEachState) {
  SpinnerFaultTest test;
  test.Run();
  EXPECT_GT(test.allowed, 0);
  EXPECT_GT(test.refused["LowPower"], 0);
}

TEST(GatedFaultTest, GoesByTheBatteryOfTheTest) {
  static SpinnerFaultTest test;
  test.battery = 39;
  EXPECT_NONFATAL_FAILURE(test.Run(), "spin.ok()");
}

}  // namespace musher::testing::gated_fault_test_test
