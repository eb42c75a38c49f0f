#include "musher/modules/device/battery.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace musher::device {
namespace {

using msg::BatteryState;

constexpr double kHighestVoltage = 65.5;  // of BmsStatus, in V; no robot of this kind has more
constexpr double kHighestTemperature = 150;
constexpr double kRoundingPercent = 0.5;

Error OutOfRange(const std::string& what, double value) {
  return {BmsCode(KeyCode::kParametersInvalid), what + " of " + std::to_string(value)};
}

// The nearest whole number that T can hold; 0 for kNotMeasured.
template <class T>
T Rounded(double value) {
  if (std::isnan(value)) return 0;
  const double least = std::numeric_limits<T>::min();
  const double most = std::numeric_limits<T>::max();
  return static_cast<T>(std::clamp(std::round(value), least, most));
}

bool Jumps(const BatteryReading& from, const BatteryReading& to) {
  return std::abs(to.percent - from.percent) > BatteryFilter::kJumpPercent;
}

}  // namespace

BatteryReading FromMessage(const BatteryState& state) {
  BatteryReading reading;
  reading.percent = 100.0 * state.percentage;
  reading.voltage_v = state.voltage;
  reading.current_a = state.current;
  reading.temperature_c = state.temperature;
  if (state.design_capacity > 0) {
    reading.health_percent = 100.0 * state.capacity / state.design_capacity;
  }
  reading.present = state.present;
  reading.status = state.power_supply_status;
  reading.health = state.power_supply_health;
  reading.external_power =
      reading.Charging() || state.power_supply_status == BatteryState::kStatusNotCharging;
  return reading;
}

Result<> Validate(const BatteryReading& reading) {
  if (!reading.present) return Error{BmsCode(KeyCode::kDeviceError), "there is no battery"};
  if (std::isnan(reading.percent)) {
    return Error{BmsCode(KeyCode::kParametersInvalid), "a charge that is not a number"};
  }
  if (reading.percent < -kRoundingPercent || reading.percent > 100 + kRoundingPercent) {
    return OutOfRange("a charge (%)", reading.percent);
  }
  if (reading.voltage_v < 0 || reading.voltage_v > kHighestVoltage) {
    return OutOfRange("a voltage (V)", reading.voltage_v);
  }
  if (std::isinf(reading.current_a)) return OutOfRange("a current (A)", reading.current_a);
  if (std::abs(reading.temperature_c) > kHighestTemperature) {
    return OutOfRange("a temperature (degrees Celsius)", reading.temperature_c);
  }
  return Ok();
}

msg::BmsStatus ToBmsStatus(const BatteryReading& reading, bool motors_powered) {
  constexpr double kMilli = 1000;
  msg::BmsStatus status;
  status.batt_volt = Rounded<std::uint16_t>(reading.voltage_v * kMilli);
  status.batt_curr = Rounded<std::int16_t>(reading.current_a * kMilli);
  status.batt_soc = Rounded<std::uint8_t>(std::clamp(reading.percent, 0.0, 100.0));
  status.batt_temp = Rounded<std::int16_t>(reading.temperature_c);
  status.batt_health = Rounded<std::int8_t>(std::clamp(reading.health_percent, 0.0, 100.0));
  status.batt_loop_number = Rounded<std::int16_t>(reading.cycles.value_or(0));
  status.power_wired_charging = reading.Charging();
  status.power_finished_charging = reading.status == BatteryState::kStatusFull;
  status.power_expower_supply = reading.external_power;
  status.power_motor_shutdown = !motors_powered;
  const bool hot = reading.health == BatteryState::kHealthOverheat;
  const bool cold = reading.health == BatteryState::kHealthCold;
  status.charge_over_temp = hot && reading.Charging();
  status.discharge_over_tmp = hot && !reading.Charging();
  status.charge_under_temp = cold && reading.Charging();
  status.discharge_under_tmp = cold && !reading.Charging();
  status.cell_over_voltage = reading.health == BatteryState::kHealthOvervoltage;
  status.cell_volt_abnormal = reading.health == BatteryState::kHealthDead ||
                              reading.health == BatteryState::kHealthUnspecFailure;
  status.power_normal = !hot && !cold && !status.cell_over_voltage && !status.cell_volt_abnormal;
  return status;
}

std::optional<BatteryReading> BatteryFilter::Accept(const BatteryReading& reading) {
  last_ = reading;
  return reading;
}

std::optional<BatteryReading> BatteryFilter::Take(const BatteryReading& reading) {
  if (!last_) {
    last_ = reading;  // not published yet
    return std::nullopt;
  }
  const std::optional<BatteryReading> held = std::exchange(held_, std::nullopt);
  if (!Jumps(*last_, reading)) return Accept(reading);
  const bool same_side =
      held && (held->percent < last_->percent) == (reading.percent < last_->percent);
  if (!same_side) {
    held_ = reading;
    return std::nullopt;
  }
  const double step = std::abs(reading.percent - last_->percent);
  if (step <= std::abs(held->percent - last_->percent)) return Accept(reading);
  if (!Jumps(*held, reading)) return Accept(reading);
  held_ = reading;
  return Accept(*held);
}

}  // namespace musher::device
