#include "musher/modules/device/devices.hpp"

#include <algorithm>
#include <utility>

namespace musher::device {

Result<std::unique_ptr<Devices>> Devices::Make(const Dependencies& dependencies,
                                               const DeviceConfig& config) {
  std::unique_ptr<Devices> devices(new Devices(config.skip));
  auto led = LedDevice::Make(dependencies, config.led);
  if (!led) return led.error();
  devices->led_ = std::move(led).value();
  auto battery = BatteryDevice::Make(
      dependencies, config.battery, [led = devices->led_.get()](const msg::BmsStatus& status) {
        led->Execute(BatteryLights(status.batt_soc, status.power_wired_charging));
      });
  if (!battery) return battery.error();
  devices->battery_ = std::move(battery).value();
  auto touch = TouchDevice::Make(dependencies, config.touch);
  if (!touch) return touch.error();
  devices->touch_ = std::move(touch).value();
  auto uwb = UwbDevice::Make(dependencies, config.uwb);
  if (!uwb) return uwb.error();
  devices->uwb_ = std::move(uwb).value();
  auto power_key = PowerKeyDevice::Make(dependencies, config.power_key);
  if (!power_key) return power_key.error();
  devices->power_key_ = std::move(power_key).value();
  devices->contacts_ = std::make_unique<ContactDevices>(dependencies, config.contacts);
  devices->measurements_ = std::make_unique<MeasurementDevices>(dependencies, config.measurements);
  return devices;
}

std::vector<DeviceResult> Devices::Check() const {
  std::vector<DeviceResult> findings;
  for (const std::string_view device : kDevices) {
    if (std::find(skip_.begin(), skip_.end(), device) != skip_.end()) continue;
    findings.push_back({std::string(device), Check(device)});
  }
  return findings;
}

Result<> Devices::Check(std::string_view device) const {
  if (device == "bms") return battery_->Check();
  if (device == "touch") return touch_->Check();
  if (device == "led") return led_->Check();
  if (device == "uwb") return uwb_->Check();
  return device == "contact" ? contacts_->Check() : measurements_->Check();
}

void Devices::Enter(const State& state) {
  const bool was_low = std::exchange(low_power_, state == kLowPower);
  if (state == kTearDown) return led_->Execute(ShutdownLights());
  led_->Execute(was_low && !low_power_ ? LeavingLowPowerLights() : LowPowerLights(low_power_));
}

void Devices::OnTimeJumped() {
  battery_->OnTimeJumped();
  touch_->OnTimeJumped();
}

}  // namespace musher::device
