#pragma once
// NewModule: an actuator with a callback for each of its states.

#include <atomic>

#include "musher/actuator/machine_actuator.hpp"

// Codes of this module are 7000 plus a key: 7009 is "self-check failed". 6000 to 9999 are free.
constexpr auto kNewModule = static_cast<musher::ModuleCode>(7000);

class NewModule : public musher::MachineActuator {
 public:
  // A callback is idempotent: it may run again in the same state.
  NewModule() : MachineActuator("new_module") {
    RegisterStateCallback("SetUp", [this] { return Open(); });
    RegisterStateCallback("SelfCheck", [this] { return Check(); });
    RegisterStateCallback("Active", [this] { return SetPower(true); });
    RegisterStateCallback("LowPower", [this] { return SetPower(false); });
    RegisterStateCallback("TearDown", [this] { return SetPower(false); });
  }

  bool powered() const { return powered_; }

 protected:
  // Runs at once, concurrently with any callback, and again when that callback ends.
  void OnEmergencyStop() override { powered_ = false; }

 private:
  // Here the module opens its device.
  musher::Result<> Open() {
    open_ = true;
    return musher::Ok();
  }

  // A failure carries a sentence, which `musher` shows.
  musher::Result<> Check() {
    if (open_) return musher::Ok();
    return musher::Error{MakeCode(kNewModule, musher::KeyCode::kSelfCheckFailed),
                         "the device is not open"};
  }

  musher::Result<> SetPower(bool on) {
    powered_ = on;
    // A later stop runs OnEmergencyStop(); an earlier one is detected here.
    if (EmergencyStopped()) powered_ = false;
    Log(powered_ ? "power on" : "power off");
    return musher::Ok();
  }

  bool open_ = false;
  std::atomic<bool> powered_ = false;
};
