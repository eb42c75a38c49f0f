#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// sensor_msgs/msg/BatteryState: what is not measured is NaN.
struct BatteryState {
  static constexpr std::string_view kTypeName = "sensor_msgs::msg::dds_::BatteryState_";

  static constexpr std::uint8_t kStatusUnknown = 0;
  static constexpr std::uint8_t kStatusCharging = 1;
  static constexpr std::uint8_t kStatusDischarging = 2;
  static constexpr std::uint8_t kStatusNotCharging = 3;
  static constexpr std::uint8_t kStatusFull = 4;
  static constexpr std::uint8_t kHealthUnknown = 0;
  static constexpr std::uint8_t kHealthGood = 1;
  static constexpr std::uint8_t kHealthOverheat = 2;
  static constexpr std::uint8_t kHealthDead = 3;
  static constexpr std::uint8_t kHealthOvervoltage = 4;
  static constexpr std::uint8_t kHealthUnspecFailure = 5;
  static constexpr std::uint8_t kHealthCold = 6;
  static constexpr std::uint8_t kHealthWatchdogTimerExpire = 7;
  static constexpr std::uint8_t kHealthSafetyTimerExpire = 8;
  static constexpr std::uint8_t kTechnologyUnknown = 0;
  static constexpr std::uint8_t kTechnologyNimh = 1;
  static constexpr std::uint8_t kTechnologyLion = 2;
  static constexpr std::uint8_t kTechnologyLipo = 3;
  static constexpr std::uint8_t kTechnologyLife = 4;
  static constexpr std::uint8_t kTechnologyNicd = 5;
  static constexpr std::uint8_t kTechnologyLimn = 6;

  Header header;
  float voltage = 0;
  float temperature = 0;
  float current = 0;
  float charge = 0;
  float capacity = 0;
  float design_capacity = 0;
  float percentage = 0;
  std::uint8_t power_supply_status = 0;
  std::uint8_t power_supply_health = 0;
  std::uint8_t power_supply_technology = 0;
  bool present = false;
  std::vector<float> cell_voltage;
  std::vector<float> cell_temperature;
  std::string location;
  std::string serial_number;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.voltage, m.temperature, m.current, m.charge, m.capacity,
                    m.design_capacity, m.percentage, m.power_supply_status, m.power_supply_health,
                    m.power_supply_technology, m.present, m.cell_voltage, m.cell_temperature,
                    m.location, m.serial_number);
  }
  friend bool operator==(const BatteryState&, const BatteryState&) = default;
};

}  // namespace musher::msg
