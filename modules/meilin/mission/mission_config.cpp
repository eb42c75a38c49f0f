#include "musher/modules/meilin/mission/mission_config.hpp"

#include <filesystem>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::meilin {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr double kLongestS = 3600;
constexpr double kFarthestM = 1000;

// An empty one is none.
Row OptionalFile(std::string_view key, std::string& path, const std::filesystem::path& folder) {
  return [key, &path, &folder](TableReader& root) {
    const auto word = root.String(key);
    if (word && !word->text.empty()) path = config_toml::Absolute(folder, word->text);
  };
}

Row Name(std::string_view key, std::string& name) {
  return row::Topic(key, name, "mf_action_seq", {.of = "a topic, service or action"});
}

void ReadWheelOrder(TableReader& root, std::array<std::size_t, 4>& wheels) {
  constexpr const char* kKey = "meilin_wheel_order";
  const auto order = root.Integers(kKey, 0, 3);
  if (!order) return;
  std::array<bool, 4> seen{};
  for (const std::int64_t wheel : *order) seen.at(static_cast<std::size_t>(wheel)) = true;
  if (order->size() != 4 || !(seen[0] && seen[1] && seen[2] && seen[3])) {
    return root.Fault(root.At(kKey), kKey, "expected 0, 1, 2 and 3 in some order");
  }
  for (std::size_t i = 0; i < 4; ++i) wheels.at(i) = static_cast<std::size_t>(order->at(i));
}

void ReadInitialCell(TableReader& root, Cell& initial) {
  constexpr const char* kKey = "meilin_initial_grid";
  const auto cell = root.Integers(kKey, 0, kRows - 1);
  if (!cell) return;
  initial = {static_cast<int>(cell->empty() ? 0 : cell->at(0)),
             static_cast<int>(cell->size() > 1 ? cell->at(1) : 0)};
  if (cell->size() == 2 && IsInside(initial)) return;
  root.Fault(root.At(kKey), kKey, "expected [row, column]: rows 0 to 5, columns 0 to 2");
}

Rows ProgramRows(MissionConfig& config, const std::filesystem::path& folder) {
  return {
      row::Required("tree_file", "the XML of the tree, as in \"full_match.xml\"",
                    OptionalFile("tree_file", config.tree_file, folder)),
      OptionalFile("match_config", config.match_config, folder),
      row::Number("tick_frequency", config.tick_frequency_hz, 1, 1000),
      row::Integer("groot2_port", config.groot2_port, 0, 65534),
      row::Bool("groot2_hooks", config.groot2_hooks),
      row::Text("record", config.record),
      row::Integer("record_mib", config.record_mib, 1, 256),
      Name("segment_topic", config.segment_topic),
      Name("mf_action_topic", config.action_topic),
      Name("buffer_service", config.buffer_service),
      row::Bool("plan_service", config.plan_service),
      Name("meilin_pose_topic", config.pose_topic),
      Name("meilin_chassis_topic", config.chassis_topic),
      Name("meilin_map_topic", config.map_topic),
      [&](TableReader& root) { ReadWheelOrder(root, config.wheel_order); },
      row::Bool("autostart", config.autostart),
      row::Number("self_check_sec", config.self_check_s, 0, kLongestS),
  };
}

Rows FieldRows(Settings& settings) {
  Point2& origin = settings.grid.origin;
  return {
      row::Choice("meilin_side", settings.grid.side, {{"blue", Side::kBlue}, {"red", Side::kRed}}),
      row::Number("meilin_grid_size", settings.grid.size_m, 0.1, kFarthestM),
      row::Numbers("meilin_grid_origin", {&origin.x_m, &origin.y_m}, -kFarthestM, kFarthestM,
                   "expected two numbers, [x, y] in metres"),
      [&](TableReader& root) { ReadInitialCell(root, settings.initial_cell); },
      row::Number("meilin_initial_height", settings.initial_height_mm, -1000, 1000),
      row::Number("meilin_initial_yaw", settings.initial_yaw_rad, -kPi, kPi),
      row::Number("meilin_grasp_distance", settings.grid.grasp_distance_m, 0, 10),
      row::Number("meilin_cell_center_tolerance", settings.grid.centre_tolerance_m, 0, 1),
  };
}

Rows LimitRows(Settings& settings) {
  return {
      row::Number("meilin_yaw_tolerance", settings.yaw_tolerance_rad, 0, 1),
      row::Number("meilin_height_tolerance", settings.height_tolerance_mm, 0, 100),
      row::Number("meilin_default_align_timeout", settings.align_timeout_s, -1, kLongestS),
      row::Number("meilin_default_suspension_timeout", settings.suspension_timeout_s, 0.1,
                  kLongestS),
      row::Number("meilin_default_grasp_timeout", settings.grasp_timeout_s, 0.1, kLongestS),
      row::Number("meilin_suspension_normal_height", settings.normal_height_mm, 0, 1000),
      row::Number("meilin_pose_timeout_sec", settings.pose_timeout_s, -1, kLongestS),
  };
}

MissionConfig Read(const Table& table, const std::string& path, Findings& findings) {
  const std::filesystem::path folder = config_toml::FolderOf(path);
  MissionConfig config;
  config.file = path;
  Rows rows;
  for (const Rows& part :
       {ProgramRows(config, folder), FieldRows(config.settings), LimitRows(config.settings)}) {
    rows.insert(rows.end(), part.begin(), part.end());
  }
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root, rows);
  return config;
}

}  // namespace

Parsed<MissionConfig> ReadMissionText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<MissionConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings); });
}

Parsed<MissionConfig> ReadMissionFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadMissionText);
}

}  // namespace musher::meilin
