#include "musher/modules/meilin/mission/mission_config.hpp"

#include <cmath>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::meilin {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr double kLongestS = 3600;
constexpr double kFarthestM = 1000;

class MissionReader {
 public:
  MissionReader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {
    config_.file = path;
  }

  MissionConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    root.Require("tree_file", "the XML of the tree, as in \"full_match.xml\"");
    config_.tree_file = Path(root, "tree_file");
    config_.match_config = Path(root, "match_config");
    Take(root, "tick_frequency", 1, 1000, config_.tick_frequency_hz);
    config_.groot2_port =
        static_cast<std::uint16_t>(root.Integer("groot2_port", 0, 65534).value_or(0));
    config_.groot2_hooks = root.Bool("groot2_hooks").value_or(false);
    if (const auto record = root.String("record")) config_.record = record->text;
    config_.record_mib = static_cast<std::size_t>(root.Integer("record_mib", 1, 256).value_or(16));
    Topic(root, "segment_topic", config_.segment_topic);
    Topic(root, "mf_action_topic", config_.action_topic);
    Topic(root, "buffer_service", config_.buffer_service);
    config_.plan_service = root.Bool("plan_service").value_or(false);
    Topic(root, "meilin_pose_topic", config_.pose_topic);
    Topic(root, "meilin_chassis_topic", config_.chassis_topic);
    Topic(root, "meilin_map_topic", config_.map_topic);
    ReadWheelOrder(root);
    config_.autostart = root.Bool("autostart").value_or(false);
    Take(root, "self_check_sec", 0, kLongestS, config_.self_check_s);
    ReadField(root);
    ReadLimits(root);
    root.RefuseOthers();
    return config_;
  }

 private:
  void ReadField(TableReader& root) {
    Settings& settings = config_.settings;
    settings.grid.side =
        root.Choice<Side>("meilin_side", {{"blue", Side::kBlue}, {"red", Side::kRed}})
            .value_or(Side::kBlue);
    Take(root, "meilin_grid_size", 0.1, kFarthestM, settings.grid.size_m);
    if (const auto origin = Numbers(root, "meilin_grid_origin", kFarthestM)) {
      settings.grid.origin = {origin->at(0), origin->at(1)};
    }
    const auto cell = root.Integers("meilin_initial_grid", 0, kRows - 1);
    if (cell) {
      settings.initial_cell = {static_cast<int>(cell->empty() ? 0 : cell->at(0)),
                               static_cast<int>(cell->size() > 1 ? cell->at(1) : 0)};
      if (cell->size() != 2 || !IsInside(settings.initial_cell)) {
        root.Fault(root.At("meilin_initial_grid"), "meilin_initial_grid",
                   "expected [row, column]: rows 0 to 5, columns 0 to 2");
      }
    }
    Take(root, "meilin_initial_height", -1000, 1000, settings.initial_height_mm);
    Take(root, "meilin_initial_yaw", -kPi, kPi, settings.initial_yaw_rad);
    Take(root, "meilin_grasp_distance", 0, 10, settings.grid.grasp_distance_m);
    Take(root, "meilin_cell_center_tolerance", 0, 1, settings.grid.centre_tolerance_m);
  }

  void ReadWheelOrder(TableReader& root) {
    constexpr const char* kKey = "meilin_wheel_order";
    const auto order = root.Integers(kKey, 0, 3);
    if (!order) return;
    std::array<bool, 4> seen{};
    for (const std::int64_t wheel : *order) seen.at(static_cast<std::size_t>(wheel)) = true;
    if (order->size() != 4 || !(seen[0] && seen[1] && seen[2] && seen[3])) {
      return root.Fault(root.At(kKey), kKey, "expected 0, 1, 2 and 3 in some order");
    }
    for (std::size_t i = 0; i < 4; ++i) {
      config_.wheel_order.at(i) = static_cast<std::size_t>(order->at(i));
    }
  }

  void ReadLimits(TableReader& root) {
    Settings& settings = config_.settings;
    Take(root, "meilin_yaw_tolerance", 0, 1, settings.yaw_tolerance_rad);
    Take(root, "meilin_height_tolerance", 0, 100, settings.height_tolerance_mm);
    Take(root, "meilin_default_align_timeout", -1, kLongestS, settings.align_timeout_s);
    Take(root, "meilin_default_suspension_timeout", 0.1, kLongestS, settings.suspension_timeout_s);
    Take(root, "meilin_default_grasp_timeout", 0.1, kLongestS, settings.grasp_timeout_s);
    Take(root, "meilin_suspension_normal_height", 0, 1000, settings.normal_height_mm);
    Take(root, "meilin_pose_timeout_sec", -1, kLongestS, settings.pose_timeout_s);
  }

  static void Take(TableReader& root, std::string_view key, double least, double most,
                   double& value) {
    value = root.Number(key, least, most).value_or(value);
  }

  // [x, y]
  std::optional<std::vector<double>> Numbers(TableReader& root, std::string_view key, double most) {
    const config_toml::Value* value = root.Get(key);
    if (value == nullptr) return std::nullopt;
    std::vector<double> numbers;
    if (const auto* list = std::get_if<config_toml::Array>(&value->content)) {
      for (const config_toml::Value& each : *list) {
        if (const auto* real = std::get_if<double>(&each.content)) numbers.push_back(*real);
        if (const auto* whole = std::get_if<std::int64_t>(&each.content)) {
          numbers.push_back(static_cast<double>(*whole));
        }
      }
    }
    bool fits = numbers.size() == 2;
    for (const double number : numbers) fits = fits && std::abs(number) <= most;
    if (fits) return numbers;
    root.Fault(root.At(key), key, "expected two numbers, [x, y] in metres");
    return std::nullopt;
  }

  std::string Path(TableReader& root, std::string_view key) {
    const std::optional<Word> path = root.String(key);
    if (!path || path->text.empty()) return "";
    return config_toml::Absolute(folder_, path->text);
  }

  static void Topic(TableReader& root, std::string_view key, std::string& name) {
    const std::optional<Word> topic = root.String(key);
    if (!topic) return;
    name = topic->text;
    if (config_toml::IsTopic(name)) return;
    root.Fault(topic->at, key,
               "expected a name as in \"mf_action_seq\", found " + config_toml::Quote(name));
  }

  const std::filesystem::path folder_;
  Findings& findings_;
  MissionConfig config_;
};

}  // namespace

MissionReading ReadMissionText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<MissionReading>(
      text, path, [&](const Table& root, Findings& findings) {
        return MissionReader(path, findings).Read(root);
      });
}

MissionReading ReadMissionFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadMissionText);
}

}  // namespace musher::meilin
