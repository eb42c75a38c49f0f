#include "musher/modules/meilin/servers/server_config.hpp"

#include <set>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::meilin::servers {
namespace {

namespace row = config_toml::row;
using config_toml::Row;
using config_toml::Rows;
using config_toml::TableReader;

enum class Kind { kMove, kSuspension, kArm, kSpear };

// A topic, with its default as the example.
Row Topic(std::string_view key, std::string& topic) {
  return row::Topic(key, topic, topic);
}

Row Gains(std::string_view key, PidGains& gains) {
  return row::Numbers(key, {&gains.p, &gains.i, &gains.d}, 0, 1000,
                      "expected three numbers from 0 to 1000: [p, i, d]");
}

// Where front-left, front-right, rear-left and rear-right are: each of 0 to 3 once.
Row Order(std::string_view key, Corners& order) {
  return [key, &order](TableReader& reader) {
    const auto read = reader.Integers(key, 0, kWheels - 1);
    if (!read) return;
    const std::set<std::int64_t> each(read->begin(), read->end());
    if (read->size() != kWheels || each.size() != kWheels) {
      reader.Fault(reader.At(key), key, "expected each of 0, 1, 2 and 3 once");
      return;
    }
    for (std::size_t i = 0; i < kWheels; ++i) order[i] = static_cast<std::size_t>((*read)[i]);
  };
}

Rows MoveRows(MoveConfig& config) {
  MoveSettings& s = config.settings;
  return {
      row::Time("period_ms", s.period),
      row::Time("pose_wait_ms", s.pose_wait),
      row::Time("pose_stale_ms", s.pose_stale),
      row::Time("yaw_limit_ms", s.yaw_limit),
      row::Time("xy_limit_ms", s.xy_limit),
      row::Time("brake_ms", s.brake_time),
      row::Number("yaw_tolerance_deg", s.yaw_tolerance_deg, 0.01, 90),
      row::Number("xy_tolerance_m", s.xy_tolerance_m, 0.001, 1),
      row::Number("max_m_s", s.max_m_s, 0.01, 10),
      row::Number("min_m_s", s.min_m_s, 0, 10),
      row::Number("climb_m_s", s.climb_m_s, 0, 10),
      row::Number("brake_m_s2", s.brake_m_s2, 0, 100),
      row::Number("max_yaw_rad_s", s.max_yaw_rad_s, 0.01, 20),
      row::Number("min_yaw_rad_s", s.min_yaw_rad_s, 0, 20),
      row::Number("max_xy_yaw_rad_s", s.max_xy_yaw_rad_s, 0, 20),
      row::Number("integral_limit", s.integral_limit, 0, 1000),
      Gains("yaw_pid", s.yaw),
      Gains("xy_yaw_pid", s.xy_yaw),
      Gains("x_pid", s.x),
      Gains("y_pid", s.y),
      row::Check(
          "min_m_s", [&] { return s.min_m_s <= s.max_m_s; }, "greater than the greatest speed"),
      row::Check(
          "min_yaw_rad_s", [&] { return s.min_yaw_rad_s <= s.max_yaw_rad_s; },
          "greater than the greatest speed"),
      row::Text("frame", config.frame),
      Topic("action", config.action),
      Topic("pose", config.pose),
      Topic("command", config.command),
      Topic("climb_state", config.climb_state),
  };
}

Rows SuspensionRows(SuspensionConfig& config) {
  SuspensionSettings& s = config.settings;
  return {
      row::Number("rest_mm", s.rest_mm, 0, 1000),
      row::Number("low_mm", s.low_mm, 0, 1000),
      row::Number("high_mm", s.high_mm, 0, 1000),
      row::Number("low_step_mm", s.low_step_mm, 0, 1000),
      row::Number("highest_step_mm", s.highest_step_mm, 0, 1000),
      row::Number("highest_mm", s.highest_mm, 0, 1000),
      row::Number("tolerance_mm", s.tolerance_mm, 0.1, 100),
      row::Time("limit_ms", s.time_limit),
      row::Time("stale_ms", s.stale),
      row::Check(
          "high_mm", [&] { return s.high_mm <= s.highest_mm; },
          "no wheel reaches it, see highest_mm"),
      row::Check(
          "low_mm", [&] { return s.low_mm <= s.high_mm; }, "greater than high_mm"),
      Order("wheel_order", config.wheel_order),
      Order("switch_order", config.switch_order),
      Topic("action", config.action),
      Topic("command", config.command),
      Topic("chassis", config.chassis),
      Topic("distances", config.distances),
      Topic("state", config.state),
  };
}

Rows ToolRows(ToolConfig& config) {
  Rows rows = {
      row::Time("limit_ms", config.time_limit),
      Topic("action", config.action),
      Topic("command", config.command),
      Topic("report", config.report),
  };
  if (!config.runtime_state.empty()) rows.push_back(Topic("runtime_state", config.runtime_state));
  return rows;
}

// Those of the server, whose defaults `config` has from now on.
Rows RowsOf(Kind kind, ServerConfig& config) {
  switch (kind) {
    case Kind::kMove:
      return MoveRows(config.server.emplace<MoveConfig>());
    case Kind::kSuspension:
      return SuspensionRows(config.server.emplace<SuspensionConfig>());
    case Kind::kArm:
      return ToolRows(config.server.emplace<ArmConfig>());
    case Kind::kSpear:
      break;
  }
  return ToolRows(config.server.emplace<SpearConfig>());
}

ServerConfig ReadServer(const config_toml::Table& table, config_toml::Findings& findings) {
  ServerConfig config;
  TableReader root(table, {1, 1}, "", findings);
  root.Require("server", "the server: \"move_to_pose\", \"suspension\", \"arm\" or \"spear\"");
  const auto kind = root.Choice<Kind>("server", {{"move_to_pose", Kind::kMove},
                                                 {"suspension", Kind::kSuspension},
                                                 {"arm", Kind::kArm},
                                                 {"spear", Kind::kSpear}});
  if (!kind) return config;  // without it no other key is known
  Rows rows = RowsOf(*kind, config);
  rows.insert(rows.begin(), row::Time("self_check_ms", config.self_check_time));
  ReadRows(root, rows);
  return config;
}

}  // namespace

Parsed<ServerConfig> ReadServerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<ServerConfig>>(text, path, ReadServer);
}

Parsed<ServerConfig> ReadServerFile(const std::string& path) {
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
