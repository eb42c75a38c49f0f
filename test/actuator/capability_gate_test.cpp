// Whether an actuator's own functions may run now.

#include "musher/actuator/capability_gate.hpp"

#include <gmock/gmock.h>

#include "musher/actuator/callback_harness.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::capability_gate_test {

using ::testing::HasSubstr;

constexpr ModuleCode kLegs{3000};

class Legs : public MachineActuator {
 public:
  Legs() : MachineActuator("legs") {
    RegisterStateCallback([](const State&) { return kCodeOk; });
  }
};

class OnesOwnFunctions : public ::testing::Test {
 protected:
  OnesOwnFunctions() : callbacks_(legs_) {}

  void Adopt() {
    const ConfigReading reading = ReadConfigText(R"(
      [controller]
      actuators = ["legs"]
      states = ["SetUp", "Active", "Protected", "LowPower"]
      default_time = 100
      default_state = "Uninitialized"
      [actuator.legs]
      states = ["SetUp", "Active", "Protected", "LowPower"]
      times = [1, 2, 3, 4]
      [capability.walk]
      actuators = ["legs"]
      states = ["Active", "Protected"]
      [capability.jump]
      actuators = ["legs"]
      min_battery = 30
    )",
                                                 "robot.toml");
    ASSERT_TRUE(reading.config);
    ASSERT_TRUE(callbacks_.Adopt(*reading.config).ok());
  }
  void Report(const State& state, const State& target = "", StopId emergency_stop = 0) {
    ActuatorReport report;
    report.state = state;
    report.target = target;
    report.emergency_stop = emergency_stop;
    callbacks_.SetReport(report);
  }

  Legs legs_;
  CallbackHarness callbacks_;
};

TEST_F(OnesOwnFunctions, AreRefusedBeforeInit) {
  const Result<> walk = legs_.Allowed("walk", kLegs);
  ASSERT_FALSE(walk.ok());
  EXPECT_EQ(walk.error().code, 3003);
  EXPECT_THAT(walk.error().message, HasSubstr("is not initialised"));
}

TEST_F(OnesOwnFunctions, FollowTheStateAndTheCallbackThatRuns) {
  Adopt();
  EXPECT_FALSE(legs_.Allowed("walk").ok()) << "it is not set up";
  Report("Active");
  EXPECT_TRUE(legs_.Allowed("walk").ok());
  Report("Active", "LowPower");
  EXPECT_FALSE(legs_.Allowed("walk").ok());
  Report("Protected");
  EXPECT_TRUE(legs_.Allowed("walk").ok());
  EXPECT_EQ(legs_.Allowed("roll", kLegs).error().code, 3013);
}

TEST_F(OnesOwnFunctions, AreRefusedWhileAnEmergencyStopIsLatched) {
  Adopt();
  Report("Active", "", 7);
  EXPECT_THAT(legs_.Allowed("walk").error().message, HasSubstr("emergency stop"));
}

TEST_F(OnesOwnFunctions, UseTheLastReceivedBatteryLevel) {
  Adopt();
  Report("Active");
  EXPECT_THAT(legs_.Allowed("jump").error().message, HasSubstr("not known"));
  callbacks_.SetBattery(80);
  EXPECT_TRUE(legs_.Allowed("jump").ok());
  callbacks_.SetBattery(29);
  EXPECT_EQ(legs_.Allowed("jump").error().code, RobotCode(KeyCode::kProtectedError));
  callbacks_.SetBattery(std::nullopt);
  EXPECT_FALSE(legs_.Allowed("jump").ok());
}

}  // namespace musher::capability_gate_test
