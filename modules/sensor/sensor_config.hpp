#pragma once
// The config of the sensor manager, a TOML file; README.md and config/sensor/sensor_manager.toml
// explain its keys.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/modules/sensor/sensor_kind.hpp"

namespace musher::sensor {

// The ToF sensors by their number in SingleTofPayload.tof_position.
inline constexpr std::array<std::string_view, 4> kTofKeys = {"left_head", "right_head", "left_rear",
                                                             "right_rear"};

struct SensorConfig {
  std::vector<std::string> sources;  // topics; empty: there is no such sensor; of ToF as kTofKeys
  Duration period{};                 // at least between two that are published; zero: no limit
  Duration silence = Milliseconds(1000);  // timeout without a reading
  std::string satellites;                 // of the GPS: the topic of their number; empty: unknown

  friend bool operator==(const SensorConfig&, const SensorConfig&) = default;
};

struct ManagerConfig {
  Duration self_check_time = Milliseconds(3000);  // how long SelfCheck waits for the sensors
  Duration start_time = Milliseconds(2000);  // how long critical ones may take to publish again
  Duration stamp_tolerance = Milliseconds(1000);  // zero: stamps are not compared with the clock
  std::optional<RosDistro> ros_distro;            // whose message layouts are published; none:
                                                  // the machine's (transport::ChosenDistro)
  std::vector<SensorKind> skip;                   // not checked
  std::vector<SensorKind> critical;               // a failure fails a self-check at once
  std::array<SensorConfig, kSensorKinds.size()> sensors;

  ManagerConfig() { Of(SensorKind::kGps).silence = Milliseconds(3000); }

  SensorConfig& Of(SensorKind kind) { return sensors.at(static_cast<std::size_t>(kind)); }
  const SensorConfig& Of(SensorKind kind) const {
    return sensors.at(static_cast<std::size_t>(kind));
  }
  friend bool operator==(const ManagerConfig&, const ManagerConfig&) = default;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<ManagerConfig> ReadManagerFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<ManagerConfig> ReadManagerText(std::string_view text, const std::string& path);

}  // namespace musher::sensor
