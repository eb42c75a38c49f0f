#include "musher/modules/meilin/servers/server_config.hpp"

#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::meilin::servers {
namespace {

using config_toml::TableReader;
using config_toml::Value;

enum class Kind { kMove, kSuspension, kArm, kSpear };

void SetNumber(TableReader& reader, std::string_view key, double least, double most,
               double& value) {
  value = reader.Number(key, least, most).value_or(value);
}

void SetTime(TableReader& reader, std::string_view key, Duration& value) {
  value = reader.Time(key).value_or(value);
}

void SetTopic(TableReader& reader, std::string_view key, std::string& value) {
  const auto topic = reader.String(key);
  if (!topic) return;
  if (!config_toml::IsTopic(topic->text)) {
    reader.Fault(topic->at, key, "expected the name of a topic, as in \"" + value + "\"");
  }
  value = topic->text;
}

std::optional<double> GainOf(const Value& value) {
  const auto* integer = value.As<std::int64_t>();
  const auto* number = value.As<double>();
  if (integer == nullptr && number == nullptr) return std::nullopt;
  const double gain = integer != nullptr ? static_cast<double>(*integer) : *number;
  constexpr double kMost = 1000;
  if (!std::isfinite(gain) || gain < 0 || gain > kMost) return std::nullopt;
  return gain;
}

void SetGains(TableReader& reader, std::string_view key, PidGains& gains) {
  const Value* value = reader.Get(key);
  if (value == nullptr) return;
  constexpr const char* kExpected = "expected three numbers from 0 to 1000: [p, i, d]";
  const auto* list = value->As<config_toml::Array>();
  if (list == nullptr || list->size() != 3) return reader.Fault(value->at, key, kExpected);
  std::array<double, 3> read{};
  for (std::size_t i = 0; i < read.size(); ++i) {
    const auto gain = GainOf((*list)[i]);
    if (!gain) return reader.Fault((*list)[i].at, key, kExpected);
    read[i] = *gain;
  }
  gains = {read[0], read[1], read[2]};
}

// Reports the key of a least value that is greater than the most.
void CheckOrder(TableReader& reader, std::string_view key, double least, double most) {
  if (least > most) reader.Fault(reader.At(key), key, "greater than the greatest speed");
}

MoveConfig ReadMove(TableReader& root) {
  MoveConfig config;
  MoveSettings& s = config.settings;
  SetTime(root, "period_ms", s.period);
  SetTime(root, "pose_wait_ms", s.pose_wait);
  SetTime(root, "pose_stale_ms", s.pose_stale);
  SetTime(root, "yaw_limit_ms", s.yaw_limit);
  SetTime(root, "xy_limit_ms", s.xy_limit);
  SetTime(root, "brake_ms", s.brake_time);
  SetNumber(root, "yaw_tolerance_deg", 0.01, 90, s.yaw_tolerance_deg);
  SetNumber(root, "xy_tolerance_m", 0.001, 1, s.xy_tolerance_m);
  SetNumber(root, "max_m_s", 0.01, 10, s.max_m_s);
  SetNumber(root, "min_m_s", 0, 10, s.min_m_s);
  SetNumber(root, "climb_m_s", 0, 10, s.climb_m_s);
  SetNumber(root, "brake_m_s2", 0, 100, s.brake_m_s2);
  SetNumber(root, "max_yaw_rad_s", 0.01, 20, s.max_yaw_rad_s);
  SetNumber(root, "min_yaw_rad_s", 0, 20, s.min_yaw_rad_s);
  SetNumber(root, "max_xy_yaw_rad_s", 0, 20, s.max_xy_yaw_rad_s);
  SetNumber(root, "integral_limit", 0, 1000, s.integral_limit);
  SetGains(root, "yaw_pid", s.yaw);
  SetGains(root, "xy_yaw_pid", s.xy_yaw);
  SetGains(root, "x_pid", s.x);
  SetGains(root, "y_pid", s.y);
  CheckOrder(root, "min_m_s", s.min_m_s, s.max_m_s);
  CheckOrder(root, "min_yaw_rad_s", s.min_yaw_rad_s, s.max_yaw_rad_s);
  if (const auto frame = root.String("frame")) config.frame = frame->text;
  SetTopic(root, "action", config.action);
  SetTopic(root, "pose", config.pose);
  SetTopic(root, "command", config.command);
  SetTopic(root, "climb_state", config.climb_state);
  return config;
}

// Where front-left, front-right, rear-left and rear-right are: each of 0 to 3 once.
void SetOrder(TableReader& reader, std::string_view key, Corners& order) {
  const auto read = reader.Integers(key, 0, kWheels - 1);
  if (!read) return;
  const std::set<std::int64_t> each(read->begin(), read->end());
  if (read->size() != kWheels || each.size() != kWheels) {
    reader.Fault(reader.At(key), key, "expected each of 0, 1, 2 and 3 once");
    return;
  }
  for (std::size_t i = 0; i < kWheels; ++i) order[i] = static_cast<std::size_t>((*read)[i]);
}

SuspensionConfig ReadSuspension(TableReader& root) {
  SuspensionConfig config;
  SuspensionSettings& s = config.settings;
  SetNumber(root, "rest_mm", 0, 1000, s.rest_mm);
  SetNumber(root, "low_mm", 0, 1000, s.low_mm);
  SetNumber(root, "high_mm", 0, 1000, s.high_mm);
  SetNumber(root, "low_step_mm", 0, 1000, s.low_step_mm);
  SetNumber(root, "highest_step_mm", 0, 1000, s.highest_step_mm);
  SetNumber(root, "highest_mm", 0, 1000, s.highest_mm);
  SetNumber(root, "tolerance_mm", 0.1, 100, s.tolerance_mm);
  SetTime(root, "limit_ms", s.time_limit);
  SetTime(root, "stale_ms", s.stale);
  if (s.high_mm > s.highest_mm) {
    root.Fault(root.At("high_mm"), "high_mm", "no wheel reaches it, see highest_mm");
  }
  if (s.low_mm > s.high_mm) root.Fault(root.At("low_mm"), "low_mm", "greater than high_mm");
  SetOrder(root, "wheel_order", config.wheel_order);
  SetOrder(root, "switch_order", config.switch_order);
  SetTopic(root, "action", config.action);
  SetTopic(root, "command", config.command);
  SetTopic(root, "chassis", config.chassis);
  SetTopic(root, "distances", config.distances);
  SetTopic(root, "state", config.state);
  return config;
}

template <class Config>
Config ReadTool(TableReader& root) {
  Config config;
  SetTime(root, "limit_ms", config.time_limit);
  SetTopic(root, "action", config.action);
  SetTopic(root, "command", config.command);
  SetTopic(root, "report", config.report);
  if (!config.runtime_state.empty()) SetTopic(root, "runtime_state", config.runtime_state);
  return config;
}

ServerConfig ReadServer(const config_toml::Table& table, config_toml::Findings& findings) {
  ServerConfig config;
  TableReader root(table, {1, 1}, "", findings);
  root.Require("server", "the server: \"move_to_pose\", \"suspension\", \"arm\" or \"spear\"");
  const auto kind = root.Choice<Kind>("server", {{"move_to_pose", Kind::kMove},
                                                 {"suspension", Kind::kSuspension},
                                                 {"arm", Kind::kArm},
                                                 {"spear", Kind::kSpear}});
  if (!kind) return config;
  SetTime(root, "self_check_ms", config.self_check_time);
  switch (*kind) {
    case Kind::kMove:
      config.server = ReadMove(root);
      break;
    case Kind::kSuspension:
      config.server = ReadSuspension(root);
      break;
    case Kind::kArm:
      config.server = ReadTool<ArmConfig>(root);
      break;
    case Kind::kSpear:
      config.server = ReadTool<SpearConfig>(root);
      break;
  }
  root.RefuseOthers();
  return config;
}

}  // namespace

ServerReading ReadServerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<ServerReading>(text, path, ReadServer);
}

ServerReading ReadServerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadServerText);
}

Result<std::unique_ptr<Server>> Make(const Dependencies& dependencies, const ServerConfig& config) {
  if (const auto* move = std::get_if<MoveConfig>(&config.server)) {
    return MoveServer::Make(dependencies, *move);
  }
  if (const auto* suspension = std::get_if<SuspensionConfig>(&config.server)) {
    return SuspensionServer::Make(dependencies, *suspension);
  }
  if (const auto* arm = std::get_if<ArmConfig>(&config.server)) {
    return ToolServer<msg::ArmAction>::Make(dependencies, *arm);
  }
  return ToolServer<msg::SpearAction>::Make(dependencies, std::get<SpearConfig>(config.server));
}

}  // namespace musher::meilin::servers
