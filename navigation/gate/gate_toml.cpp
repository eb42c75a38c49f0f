#include "musher/navigation/gate/gate_toml.hpp"

#include <cmath>
#include <cstdint>

namespace musher::navigation {
namespace {

using config_toml::TableReader;
using config_toml::Value;

constexpr double kFarM = 100;

void Set(TableReader& reader, std::string_view key, double least, double most, double& value) {
  value = reader.Number(key, least, most).value_or(value);
}

void SetSeconds(TableReader& reader, std::string_view key, double& value) {
  if (const auto time = reader.Time(key, 0)) value = ToSeconds(*time);
}

std::optional<double> NumberOf(const Value& value) {
  const auto* integer = value.As<std::int64_t>();
  const auto* number = value.As<double>();
  if (integer != nullptr) return static_cast<double>(*integer);
  if (number == nullptr || !(std::abs(*number) <= kFarM)) return std::nullopt;
  return *number;
}

std::optional<Point> CornerOf(const Value& value) {
  const auto* pair = value.As<config_toml::Array>();
  if (pair == nullptr || pair->size() != 2) return std::nullopt;
  const auto x = NumberOf((*pair)[0]), y = NumberOf((*pair)[1]);
  if (!x || !y) return std::nullopt;
  return Point{*x, *y, 0};
}

std::vector<Point> ReadCorners(TableReader& reader) {
  constexpr std::string_view kKey = "corners";
  constexpr std::string_view kExpected =
      "expected three corners or more around the body, as in [[0.8, 0.4], [0.8, -0.4], [0, 0]]";
  reader.Require(kKey, "the corners of the zone, in m from the middle of the body");
  const Value* value = reader.Get(kKey);
  if (value == nullptr) return {};
  std::vector<Point> corners;
  const auto* array = value->As<config_toml::Array>();
  for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const auto corner = CornerOf((*array)[i]);
    if (!corner) {
      reader.Fault((*array)[i].at, kKey, kExpected);
      return {};
    }
    corners.push_back(*corner);
  }
  if (corners.size() < 3) reader.Fault(value->at, kKey, kExpected);
  return corners;
}

GateZone ReadZone(TableReader& reader) {
  GateZone zone;
  reader.Require("name", "the name of the zone, for messages");
  if (const auto name = reader.String("name")) zone.name = name->text;
  zone.corners = ReadCorners(reader);
  zone.stops = reader.Choice<bool>("kind", {{"slow", false}, {"stop", true}}).value_or(false);
  Set(reader, "share", 0, 1, zone.share);
  zone.least_points =
      static_cast<int>(reader.Integer("least_points", 1, 10'000).value_or(zone.least_points));
  reader.RefuseOthers();
  return zone;
}

ScanMount ReadScanner(TableReader& reader) {
  ScanMount mount;
  reader.Require("topic", "the topic of its scans, as in \"jetbot_0/scan\"");
  if (const auto topic = reader.Topic("topic", "jetbot_0/scan")) mount.topic = topic->text;
  Set(reader, "x_m", -kFarM, kFarM, mount.on_body.at.x_m);
  Set(reader, "y_m", -kFarM, kFarM, mount.on_body.at.y_m);
  Set(reader, "z_m", -kFarM, kFarM, mount.on_body.at.z_m);
  mount.on_body.yaw_rad = reader.Number("yaw_deg", -360, 360).value_or(0) * M_PI / 180;
  mount.upside_down = reader.Bool("upside_down").value_or(false);
  for (const char* key : {"x_m", "y_m", "z_m", "yaw_deg", "upside_down"}) {
    mount.given = mount.given || reader.Has(key);
  }
  Set(reader, "least_m", 0, kFarM, mount.least_m);
  if (const auto most = reader.Number("most_m", 0.1, 1000)) mount.most_m = *most;
  reader.RefuseOthers();
  return mount;
}

void SetOptional(TableReader& reader, std::string_view key, double least, double most,
                 std::optional<double>& value) {
  if (const auto number = reader.Number(key, least, most)) value = *number;
}

void ReadDown(TableReader& reader, DownRules& rules) {
  reader.Require("topic", "the topic of its ranges, as in \"cf2x_0/range_down\"");
  if (const auto topic = reader.Topic("topic", "cf2x_0/range_down")) rules.topic = topic->text;
  Set(reader, "x_m", -kFarM, kFarM, rules.on_body.x_m);
  Set(reader, "y_m", -kFarM, kFarM, rules.on_body.y_m);
  Set(reader, "z_m", -kFarM, kFarM, rules.on_body.z_m);
  Set(reader, "foot_m", 0, kFarM, rules.foot_m);
  Set(reader, "margin_m", 0.05, 10, rules.margin_m);
  Set(reader, "ground_m", -1000, 10'000, rules.ground_m);
  Set(reader, "ground_tolerance_m", 0.02, 1, rules.ground_tolerance_m);
  Set(reader, "blind_m_s", 0, 1, rules.blind_m_s);
  Set(reader, "person_m_s", 0, 20, rules.person_m_s);
  Set(reader, "person_m", 0, 100, rules.person_m);
  Set(reader, "low_m_s", 0.02, 20, rules.low_m_s);
  rules.stale = reader.Time("stale_ms").value_or(rules.stale);
  if (const auto cone = reader.Number("cone_deg", 1, 160)) rules.cone_rad = *cone * M_PI / 180;
  SetOptional(reader, "least_m", 0, kFarM, rules.least_m);
  SetOptional(reader, "most_m", 0.1, 1000, rules.most_m);
  reader.RefuseOthers();
}

}  // namespace

std::vector<ScanMount> ReadScanners(TableReader& reader, const std::string& scan) {
  std::vector<ScanMount> scanners;
  for (TableReader& table : reader.Subs("scanner")) scanners.push_back(ReadScanner(table));
  if (scanners.empty() && !scan.empty()) scanners.push_back({.topic = scan});
  return scanners;
}

void ReadGate(TableReader& reader, GateRules& rules) {
  auto gate = reader.Sub("gate");
  if (!gate) return;
  Set(*gate, "margin_m", 0, 10, rules.margin_m);
  Set(*gate, "brake_m_s2", 0.05, 20, rules.brake_m_s2);
  SetSeconds(*gate, "reaction_ms", rules.reaction_s);
  SetSeconds(*gate, "approach_ms", rules.approach_s);
  Set(*gate, "blind_m_s", 0, 20, rules.blind_m_s);
  Set(*gate, "unknown_m_s", 0, 20, rules.unknown_m_s);
  rules.scan_stale = gate->Time("scan_stale_ms").value_or(rules.scan_stale);
  if (auto down = gate->Sub("down")) ReadDown(*down, rules.down);
  for (TableReader& table : gate->Subs("zone")) rules.zones.push_back(ReadZone(table));
  gate->RefuseOthers();
}

}  // namespace musher::navigation
