#pragma once
// A robot's module in one file: a gripper; its thermometer is a file.

#include <atomic>
#include <fstream>
#include <iostream>
#include <string>

#include "musher/actuator/machine_actuator.hpp"

// [codes]
// Codes of this module are 6100 plus a key: 6109 is "self-check failed".
constexpr auto kGripper = static_cast<musher::ModuleCode>(6100);
// [codes end]

constexpr int kHottest = 70;  // °C

// [class]
class Gripper : public musher::MachineActuator {
 public:
  Gripper() : MachineActuator("gripper") {
    RegisterStateCallback("SetUp", [this] { return CloseFully(); });
    RegisterStateCallback("SelfCheck", [this] { return CheckTemperature(); });
    RegisterStateCallback("Active", [this] { return SetPower(true); });
    RegisterStateCallback("LowPower", [this] { return SetPower(false); });
    RegisterStateCallback("TearDown", [this] { return SetPower(false); });
  }
  // [class end]

  bool powered() const { return powered_; }

  // [gate]
  // Called for a command from outside, on any thread.
  musher::Result<> Grip(double width_mm) {
    if (auto allowed = Allowed("grip", kGripper); !allowed) return allowed;
    wanted_mm_ = width_mm;
    return musher::Ok();
  }
  // [gate end]

 protected:
  // [estop]
  // Runs concurrently with any callback, and again when a callback ends that was running: so it is
  // idempotent, and uses only data that is safe to use from any thread.
  void OnEmergencyStop() override { powered_ = false; }
  // [estop end]

 private:
  // [code]
  // The short form: CyberDog's code, 0 = done.
  std::int32_t SetPower(bool on) {
    powered_ = on;
    // A later stop runs OnEmergencyStop(); an earlier one is detected here.
    if (EmergencyStopped()) powered_ = false;
    std::cout << "power " << (powered_ ? "on" : "off") << std::endl;
    return musher::kCodeOk;
  }
  // [code end]

  // [result]
  // The long form: a failure carries a sentence that `musher` shows.
  musher::Result<> CheckTemperature() {
    const int temperature = ReadTemperature();
    if (temperature <= kHottest) return musher::Ok();
    return musher::Error{MakeCode(kGripper, musher::KeyCode::kSelfCheckFailed),
                         "the motor has " + std::to_string(temperature) + " °C"};
  }
  // [result end]

  // [stop]
  // A long callback checks regularly whether it should stop.
  musher::Result<> CloseFully() {
    while (width_mm_ > 0.0) {
      if (StopRequested()) {
        return musher::Error{MakeCode(kGripper, musher::KeyCode::kTimeout), "still not closed"};
      }
      width_mm_ -= 0.5;
      Checkpoint();  // reports progress; needed with checkpoint_ms in the config
    }
    return musher::Ok();
  }
  // [stop end]

  static int ReadTemperature() {
    int temperature = 20;
    std::ifstream("temperature") >> temperature;
    return temperature;
  }

  double width_mm_ = 80.0;
  std::atomic<double> wanted_mm_ = 0.0;
  std::atomic<bool> powered_ = false;
};
