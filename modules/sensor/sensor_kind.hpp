#pragma once
// The kinds of sensors that the module has: names, numbers and codes on the interfaces.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "musher/base/code.hpp"

namespace musher::sensor {

enum class SensorKind : std::uint8_t { kLidar, kTof, kUltrasonic, kGps };

// In the order of the self-check.
inline constexpr std::array<SensorKind, 4> kSensorKinds = {
    SensorKind::kLidar, SensorKind::kTof, SensorKind::kUltrasonic, SensorKind::kGps};

std::string_view NameOf(SensorKind kind);
// 2109 of the lidar's self-check, and the like.
std::int32_t CodeOf(SensorKind kind, KeyCode key);
std::optional<SensorKind> KindOfName(std::string_view name);
// By SensorOperation's sensor_id; 0 (all sensors) is no kind.
std::optional<SensorKind> KindOfId(std::uint16_t sensor_id);

}  // namespace musher::sensor
