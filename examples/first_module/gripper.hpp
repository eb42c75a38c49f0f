#pragma once
// A robot's module in one file: a gripper, with a file as its thermometer.

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
  // Callbacks use the members below, so they have to end before those do.
  ~Gripper() override { Shutdown(); }
  // [class end]

  bool powered() const { return powered_; }

  // [gate]
  // What a command from outside calls, whatever thread it comes on.
  musher::Result<> Grip(double width_mm) {
    if (auto allowed = Allowed("grip", kGripper); !allowed) return allowed;
    wanted_mm_ = width_mm;
    return musher::Ok();
  }
  // [gate end]

 protected:
  // [estop]
  // Beside any callback, and again when one ends that was running: so it may run twice, and only
  // touches what may be touched from any thread.
  void OnEmergencyStop() override { powered_ = false; }
  // [estop end]

 private:
  // [code]
  // The short form: CyberDog's code, 0 = done.
  std::int32_t SetPower(bool on) {
    powered_ = on;
    // A stop that comes from here on finds the power on; one that came before is seen now.
    if (EmergencyStopped()) powered_ = false;
    std::cout << "power " << (powered_ ? "on" : "off") << std::endl;
    return musher::kCodeOk;
  }
  // [code end]

  // [result]
  // The long form: a failure carries a sentence that `musher` shows to people.
  musher::Result<> CheckTemperature() {
    const int temperature = ReadTemperature();
    if (temperature <= kHottest) return musher::Ok();
    return musher::Error{MakeCode(kGripper, musher::KeyCode::kSelfCheckFailed),
                         "the motor has " + std::to_string(temperature) + " °C"};
  }
  // [result end]

  // [stop]
  // A long callback looks now and then whether it is still waited for.
  musher::Result<> CloseFully() {
    while (width_mm_ > 0.0) {
      if (StopRequested()) {
        return musher::Error{MakeCode(kGripper, musher::KeyCode::kTimeout), "still not closed"};
      }
      width_mm_ -= 0.5;
      Checkpoint();  // it gets on: matters where the config has a checkpoint_ms
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
