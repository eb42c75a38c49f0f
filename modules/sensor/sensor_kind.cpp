#include "musher/modules/sensor/sensor_kind.hpp"

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/protocol/sensor.hpp"

namespace musher::sensor {
namespace {

struct Known {
  SensorKind kind;
  std::string_view name;
  ModuleCode module;
  std::uint16_t id;
};

constexpr std::array<Known, kSensorKinds.size()> kKnown = {{
    {SensorKind::kLidar, "lidar", cyberdog::module_code::kLidar, msg::SensorOperation::kLidar},
    {SensorKind::kTof, "tof", cyberdog::module_code::kTof, msg::SensorOperation::kTof},
    {SensorKind::kUltrasonic, "ultrasonic", cyberdog::module_code::kUltrasonic,
     msg::SensorOperation::kUltrasonic},
    {SensorKind::kGps, "gps", cyberdog::module_code::kGps, msg::SensorOperation::kGps},
}};

const Known& Of(SensorKind kind) {
  return kKnown.at(static_cast<std::size_t>(kind));
}

}  // namespace

std::string_view NameOf(SensorKind kind) {
  return Of(kind).name;
}

std::int32_t CodeOf(SensorKind kind, KeyCode key) {
  return MakeCode(Of(kind).module, key);
}

std::optional<SensorKind> KindOfName(std::string_view name) {
  for (const Known& known : kKnown) {
    if (known.name == name) return known.kind;
  }
  return std::nullopt;
}

std::optional<SensorKind> KindOfId(std::uint16_t sensor_id) {
  for (const Known& known : kKnown) {
    if (known.id == sensor_id) return known.kind;
  }
  return std::nullopt;
}

}  // namespace musher::sensor
