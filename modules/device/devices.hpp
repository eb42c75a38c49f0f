#pragma once
// All devices of the module together: how they interact, and how the lifecycle uses them. Runs on
// any transport.
//
// Threads: the loop's.

#include <memory>
#include <string_view>
#include <vector>

#include "musher/modules/device/battery_device.hpp"
#include "musher/modules/device/contact_devices.hpp"
#include "musher/modules/device/dependencies.hpp"
#include "musher/modules/device/device_config.hpp"
#include "musher/modules/device/led_device.hpp"
#include "musher/modules/device/measurement_devices.hpp"
#include "musher/modules/device/power_key_device.hpp"
#include "musher/modules/device/self_check.hpp"
#include "musher/modules/device/touch_device.hpp"
#include "musher/modules/device/uwb_device.hpp"

namespace musher::device {

class Devices {
 public:
  static Result<std::unique_ptr<Devices>> Make(const Dependencies& dependencies,
                                               const DeviceConfig& config);

  // Of each device in their order, except those that the config skips.
  std::vector<DeviceResult> Check() const;

  // Sets the lights for that state; the robot enters it or is driven to it again.
  void Enter(const State& state);

  // The clock went back.
  void OnTimeJumped();

  // Before the program exits: waits a moment until the last lights have been delivered.
  void Flush() { led_->Flush(); }

 private:
  explicit Devices(std::vector<std::string> skip) : skip_(std::move(skip)) {}
  Result<> Check(std::string_view device) const;

  const std::vector<std::string> skip_;
  std::unique_ptr<LedDevice> led_;
  std::unique_ptr<BatteryDevice> battery_;
  std::unique_ptr<TouchDevice> touch_;
  std::unique_ptr<UwbDevice> uwb_;
  std::unique_ptr<PowerKeyDevice> power_key_;
  std::unique_ptr<ContactDevices> contacts_;
  std::unique_ptr<MeasurementDevices> measurements_;
  bool low_power_ = false;  // the robot's state
};

}  // namespace musher::device
