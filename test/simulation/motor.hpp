#pragma once
// A motor as an actuator, for tests of the fault-injection harness.

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>

#include "musher/simulation/actuator_fault_test.hpp"

namespace musher::testing {

using simulation::ActuatorFaultTest;
using simulation::Faults;
using simulation::FaultTestFailure;

// The hardware, which outlives a process: it keeps the state of the last command.
struct Motor {
  bool powered = false;
  Faults* faults = nullptr;

  Result<> Power(bool on) {
    if (faults != nullptr && faults->ShouldFail()) return Error{6103, "the motor does not answer"};
    powered = on;
    return Ok();
  }
};

// A motor that has power in Active only, and none during an emergency stop.
class GoodMotor : public MachineActuator {
 public:
  explicit GoodMotor(Motor& motor) : MachineActuator("motor"), motor_(motor) {
    RegisterStateCallback("SetUp", [this] { return SetUp(); });
    RegisterStateCallback("SelfCheck", [] { return 0; });
    RegisterStateCallback("Active", [this] { return PowerOn(); });
    RegisterStateCallback("LowPower", [this] { return PowerOff(); });
    RegisterStateCallback("TearDown", [this] { return PowerOff(); });
  }

  bool powered() const { return motor_.powered; }
  bool stopped() const { return stopped_; }

 protected:
  virtual Result<> SetUp() {
    for (int step = 0; step < 100 && !StopRequested(); ++step) Checkpoint();
    return motor_.Power(false);
  }
  virtual Result<> PowerOn() {
    stopped_ = false;
    if (auto on = motor_.Power(true); !on) return on;
    for (int step = 0; step < 5; ++step) {
      if (StopRequested()) return Abort("requested to stop");
      if (stopped_) return Abort("stopped");
    }
    return Ok();
  }
  virtual Result<> PowerOff() { return motor_.Power(false); }
  void OnEmergencyStop() override {
    stopped_ = true;
    motor_.powered = false;
  }

  Motor& motor() { return motor_; }

 private:
  Result<> Abort(const std::string& why) {
    motor_.powered = false;
    return Error{kCodeFailed, why};
  }

  Motor& motor_;
  std::atomic<bool> stopped_ = false;
};

// A fault test of such an actuator, whose motor fails at random.
template <typename T>
struct MotorFaultTest : ActuatorFaultTest<T> {
  Motor motor;

  MotorFaultTest() {
    this->make_with_faults = [this](Faults& faults) {
      motor.faults = &faults;
      return std::make_unique<T>(motor);
    };
    this->before_scenario = [this] { motor = {}; };
    this->always = [](const T& actuator, const ActuatorReport& report) {
      if (report.state == "Active") return;
      EXPECT_FALSE(actuator.powered()) << "in " << report.state;
    };
    this->after_emergency_stop = [](const T& actuator, const ActuatorReport&) {
      EXPECT_FALSE(actuator.powered()) << "during an emergency stop";
    };
  }
  FaultTestFailure Failure() {
    auto found = this->Find();
    if (!found || !found.value()) {
      ADD_FAILURE() << (found ? "every scenario passed" : found.error().message);
      return {};
    }
    return *found.value();
  }
};

}  // namespace musher::testing
