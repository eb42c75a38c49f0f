#pragma once
// Checks and filters battery readings before they are published. Plain values, no IO.
//
// A charge that jumps by more than 5 % is held until the next reading: one wrong value is never
// published, and a true fall is published one reading late, however steep it is. Of the held
// reading and the next, the one on the same side and nearer to the last good one counts, so that
// no level in between is skipped. The very first reading is held, too: boards report 0 before they
// have measured.

#include <cstdint>
#include <limits>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"

namespace musher::device {

constexpr std::int32_t BmsCode(KeyCode key) {
  return MakeCode(cyberdog::module_code::kBms, key);
}

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

struct BatteryReading {
  double percent = kNotMeasured;  // of its full charge
  double voltage_v = kNotMeasured;
  double current_a = kNotMeasured;  // negative when it discharges
  double temperature_c = kNotMeasured;
  double health_percent = kNotMeasured;  // full charge now, of that when new
  std::optional<int> cycles;
  bool present = true;
  bool external_power = false;
  std::uint8_t status = msg::BatteryState::kStatusUnknown;
  std::uint8_t health = msg::BatteryState::kHealthUnknown;

  bool Charging() const {
    return status == msg::BatteryState::kStatusCharging || status == msg::BatteryState::kStatusFull;
  }
};

BatteryReading FromMessage(const msg::BatteryState& state);

// Fails with ParametersInvalid when a reading is impossible: no battery, no charge, a value out of
// its range.
Result<> Validate(const BatteryReading& reading);

// The fields that the reading has, the others 0; without a header.
msg::BmsStatus ToBmsStatus(const BatteryReading& reading, bool motors_powered);

class BatteryFilter {
 public:
  static constexpr double kJumpPercent = 5;

  // Takes a valid reading. Returns the one to be published now; nothing while it is held.
  std::optional<BatteryReading> Take(const BatteryReading& reading);

  // The reading that waits for the next one.
  const std::optional<BatteryReading>& held() const { return held_; }

 private:
  std::optional<BatteryReading> Accept(const BatteryReading& reading);

  std::optional<BatteryReading> last_;
  std::optional<BatteryReading> held_;
};

}  // namespace musher::device
