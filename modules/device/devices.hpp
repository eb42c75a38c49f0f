#pragma once
// All devices of the module together: what they do for each other and for the lifecycle. Runs on
// any transport.
//
// Threads: the loop's.

#include <memory>
#include <vector>

#include "musher/modules/device/battery_device.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/led_device.hpp"
#include "musher/modules/device/power_key_device.hpp"
#include "musher/modules/device/self_check.hpp"
#include "musher/modules/device/touch_device.hpp"
#include "musher/modules/device/uwb_device.hpp"

namespace musher::device {

class Devices {
 public:
  static Result<std::unique_ptr<Devices>> Make(const Dependencies& around,
                                               const DeviceConfig& config);

  // Of each device in their order, but for those the config skips.
  std::vector<DeviceFinding> Check() const;

  // The robot goes to that state, or is there again: its lights.
  void Enter(const State& state);

  // The clock went back.
  void OnTimeJumped();

  // Before the program ends: waits a moment until the last lights have arrived.
  void Flush() { led_->Flush(); }

 private:
  explicit Devices(std::vector<std::string> skip) : skip_(std::move(skip)) {}

  const std::vector<std::string> skip_;
  std::unique_ptr<LedDevice> led_;
  std::unique_ptr<BatteryDevice> battery_;
  std::unique_ptr<TouchDevice> touch_;
  std::unique_ptr<UwbDevice> uwb_;
  std::unique_ptr<PowerKeyDevice> power_key_;
  bool low_power_ = false;  // the robot's state
};

}  // namespace musher::device
