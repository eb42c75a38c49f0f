#pragma once
// What a battery says, judged before anybody acts on it. Plain values, no IO.
//
// A charge that jumps by more than 5 % is held until the next reading: one wrong value is never
// told to anybody, and a true fall is told one reading late, however steep it goes on. Of the held
// reading and the next, that on the same side counts that is nearer to the last good one, so no
// level in between is skipped. The first reading of all is held, too: boards say 0 before they have
// measured.

#include <cstdint>
#include <limits>
#include <optional>

#include "musher/lifecycle/result.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/sensor_msgs/battery_state.hpp"

namespace musher::device {

constexpr std::int32_t BmsCode(KeyCode key) {
  return MakeCode(ModuleCode::kBms, key);
}

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

struct BatteryReading {
  double percent = kNotMeasured;  // of its full charge
  double voltage_v = kNotMeasured;
  double current_a = kNotMeasured;  // negative when it discharges
  double temperature_c = kNotMeasured;
  double health_percent = kNotMeasured;  // full charge now to that when it was new
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

// Fails with ParametersInvalid where a reading cannot be true: no battery, no charge, a value out
// of its range.
Result<> Judge(const BatteryReading& reading);

// The fields as far as the reading knows them, the others 0; without a header.
msg::BmsStatus ToBmsStatus(const BatteryReading& reading, bool motors_powered);

class BatteryFilter {
 public:
  static constexpr double kJumpPercent = 5;

  // Takes a reading that Judge() lets pass. Gives the one to be told now; nothing while it is held.
  std::optional<BatteryReading> Take(const BatteryReading& reading);

  // That waits for the next one.
  const std::optional<BatteryReading>& held() const { return held_; }

 private:
  std::optional<BatteryReading> Accept(const BatteryReading& reading);

  std::optional<BatteryReading> last_;
  std::optional<BatteryReading> held_;
};

}  // namespace musher::device
