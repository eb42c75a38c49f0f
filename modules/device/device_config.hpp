#pragma once
// The device manager's config; README.md and config/device/device_manager.toml explain its keys.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/modules/device/can_lights.hpp"
#include "musher/modules/device/can_protocol.hpp"
#include "musher/modules/device/contact_devices.hpp"
#include "musher/modules/device/gpio_lights.hpp"
#include "musher/modules/device/gpio_line.hpp"
#include "musher/modules/device/host_lights.hpp"
#include "musher/modules/device/i2c_registers.hpp"
#include "musher/modules/device/input_device.hpp"
#include "musher/modules/device/measurement_devices.hpp"
#include "musher/modules/device/power_supply.hpp"

namespace musher::device {

enum class BatterySource : std::uint8_t { kNone, kWorld, kHost, kCan, kI2c };

struct BatteryConfig {
  BatterySource source = BatterySource::kNone;
  std::string folder = kPowerSupplyFolder;  // host: absolute
  std::string name;                         // host; empty: the first
  Duration period = Milliseconds(1000);     // host: how often it is read
  Duration silence = Milliseconds(5000);    // timeout without a reading
  CanProtocol frames;                       // can
  I2cProtocol registers;                    // i2c

  friend bool operator==(const BatteryConfig&, const BatteryConfig&) = default;
};

enum class KeySource : std::uint8_t { kNone, kWorld, kInput, kGpio };

inline constexpr std::uint16_t kPowerKeyCode = 116;  // KEY_POWER of linux/input-event-codes.h

struct PowerKeyConfig {
  KeySource source = KeySource::kNone;
  std::string device;                  // input: "/dev/input/event0"
  std::uint16_t code = kPowerKeyCode;  // input: of the key
  Duration hold = Milliseconds(3000);  // pressed for this long it requests power-off
  GpioSpec line;                       // gpio

  friend bool operator==(const PowerKeyConfig&, const PowerKeyConfig&) = default;
};

// The keys of a touch pad (linux/input-event-codes.h); 0: it has none for that.
struct TouchCodes {
  std::uint16_t tap = 0;  // pressed while it is touched
  std::uint16_t single = 0;
  std::uint16_t double_tap = 0;
  std::uint16_t hold = 0;

  friend bool operator==(const TouchCodes&, const TouchCodes&) = default;
};
inline constexpr std::uint16_t kTouchCode = 330;  // BTN_TOUCH

struct TouchConfig {
  KeySource source = KeySource::kNone;
  InputSource input;             // input
  TouchCodes codes{kTouchCode};  // input
  GpioSpec line;                 // gpio: active while it is touched

  friend bool operator==(const TouchConfig&, const TouchConfig&) = default;
};

enum class LedSource : std::uint8_t { kNone, kWorld, kHost, kCan, kGpio };

struct LedConfig {
  LedSource source = LedSource::kNone;
  std::string folder = kLedFolder;  // host: absolute
  LedNames names;                   // host
  LightProtocols frames;            // can
  LampLines lines;                  // gpio

  friend bool operator==(const LedConfig&, const LedConfig&) = default;
};

struct DeviceConfig {
  Duration self_check_time = Milliseconds(3000);  // how long SelfCheck waits for the devices
  std::vector<std::string> skip;                  // not checked
  std::vector<std::string> critical;              // a failure fails SelfCheck with its code
  BatteryConfig battery;
  TouchConfig touch;
  LedConfig led;
  bool uwb = false;  // there is one, on the world's topic
  PowerKeyConfig power_key;
  std::vector<ContactConfig> contacts;          // on GPIO lines
  std::vector<MeasurementConfig> measurements;  // of I2C buses

  friend bool operator==(const DeviceConfig&, const DeviceConfig&) = default;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<DeviceConfig> ReadDeviceFile(const std::string& path);

// The same for a text; `path` is what diagnostics and relative paths refer to.
Parsed<DeviceConfig> ReadDeviceText(std::string_view text, const std::string& path);

}  // namespace musher::device
