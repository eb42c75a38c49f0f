#include "musher/modules/world/scene_file/scene_field.hpp"

#include <map>
#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/modules/world/body/lift_body.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

using config_toml::Findings;
using config_toml::Position;
using config_toml::TableReader;
using keys::Set;

constexpr int kMostFieldCells = 50;  // in a row or a column
constexpr double kHighestMm = 2000;
constexpr double kLongestToolS = 600;
constexpr std::array<const char*, 7> kArmKeys{"idle_s",         "grasp_s",    "store_to_body_s",
                                              "store_on_arm_s", "get_body_s", "place_mid_s",
                                              "place_high_s"};
constexpr std::array<const char*, 5> kSpearKeys{"idle_s", "prepare_s", "grasp_s", "dock_extend_s",
                                                "dock_release_s"};

class FieldReader {
 public:
  FieldReader(const Choices& choices, Findings& findings, Scene& scene)
      : choices_(choices), findings_(findings), scene_(scene) {}

  void Read(TableReader& root) {
    at_ = root.At("field");
    keys::Section(root, "field", findings_, [&](TableReader& reader) { ReadGrid(reader); });
    keys::Each(root, "kfs", findings_, [&](TableReader& reader) { ReadBox(reader); });
    const Position robot_at = root.At("r2");
    keys::Section(root, "r2", findings_, [&](TableReader& reader) { ReadRobot(reader); });
    keys::Section(root, "r1", findings_, [&](TableReader& reader) {
      Set(field_.partner.ready_after_s, reader.Number("ready_after_s", 0, kLongestToolS));
    });
    if (findings_.HasErrors()) return;
    CheckPlace();
    if (const auto refused =
            LiftBody(field_).PutDown(field_, field_.robot.start_m, field_.robot.start_yaw_rad)) {
      findings_.Error(robot_at, "r2: at its start " + *refused);
    }
    scene_.field = std::move(field_);
  }

 private:
  void ReadGrid(TableReader& reader) {
    if (const auto side = choices_.String(reader, "side")) {
      field_.side = side->text;
      if (side->text != "blue" && side->text != "red") {
        reader.Fault(side->at, "side",
                     "expected blue or red, found " + config_toml::Quote(side->text) +
                         findings_.Guess(side->text, {"blue", "red"}));
      }
    }
    if (const auto rows = reader.Integer("rows", 1, kMostFieldCells)) {
      field_.rows = static_cast<int>(*rows);
    }
    if (const auto cols = reader.Integer("cols", 1, kMostFieldCells)) {
      field_.cols = static_cast<int>(*cols);
    }
    Set(field_.cell_m, reader.Number("cell_m", 0.7, 10));
    Set(field_.origin_m, keys::Pair(reader, "origin_m"));
    for (const char* side : {"blue", "red"}) {
      const std::string key = std::string(side) + "_mm";
      reader.Require(key, "the heights of the platforms, row by row");
      const auto heights = reader.Integers(key, 0, static_cast<std::int64_t>(kHighestMm));
      if (!heights) continue;
      const auto cells = static_cast<std::size_t>(field_.rows * field_.cols);
      if (heights->size() != cells) {
        reader.Fault(reader.At(key), key,
                     "expected " + std::to_string(cells) + " heights, rows times cols, found " +
                         std::to_string(heights->size()));
      } else if (field_.side == side) {
        field_.heights_mm.assign(heights->begin(), heights->end());
      }
    }
  }

  void ReadBox(TableReader& reader) {
    KfsSpec box;
    reader.Require("name", config_toml::kNameRule);
    if (const auto name = reader.String("name")) {
      box.name = name->text;
      Unique(reader, *name);
    }
    reader.Require("kind", "KFS1, KFS2 or fake");
    Set(box.kind, reader.Choice<KfsKind>("kind", {{"KFS1", KfsKind::kKfs1},
                                                  {"KFS2", KfsKind::kKfs2},
                                                  {"fake", KfsKind::kFake}}));
    for (const auto& [key, index, most] : {std::tuple("row", &box.cell.row, field_.rows),
                                           std::tuple("col", &box.cell.col, field_.cols)}) {
      reader.Require(key, "a place in the grid");
      if (const auto number = reader.Integer(key, 0, most - 1)) *index = static_cast<int>(*number);
    }
    const auto side = reader.Choice<std::string_view>("side", {{"blue", "blue"}, {"red", "red"}});
    if (side && *side != field_.side) return;
    const auto [other, first] = cells_.try_emplace({box.cell.row, box.cell.col}, box.name);
    if (!first) {
      findings_.Error(reader.at(), reader.path() + ": its cell has the box " +
                                       config_toml::Quote(other->second) + " already");
    }
    field_.boxes.push_back(std::move(box));
  }

  void Unique(TableReader& reader, const config_toml::Word& name) {
    if (!config_toml::IsName(name.text)) {
      reader.Fault(name.at, "name",
                   "expected " + std::string(config_toml::kNameRule) + ", found " +
                       config_toml::Quote(name.text));
    }
    const auto [other, first] = names_.try_emplace(name.text, name.at);
    if (!first) {
      reader.Fault(name.at, "name",
                   config_toml::Quote(name.text) + " is taken, by the one in line " +
                       std::to_string(other->second.line));
    }
  }

  void ReadRobot(TableReader& reader) {
    LiftSpec& robot = field_.robot;
    robot.start_m = keys::Center(reader);
    Set(robot.start_yaw_rad, keys::Angle(reader, "yaw_deg"));
    Set(robot.speed_m_s, reader.Number("speed_m_s", 0.01, 5));
    Set(robot.acceleration_m_s2, reader.Number("acceleration_m_s2", 0.05, 50));
    Set(robot.turn_rad_s, reader.Number("turn_rad_s", 0.01, 10));
    Set(robot.turn_acceleration_rad_s2, reader.Number("turn_acceleration_rad_s2", 0.05, 100));
    Set(robot.command_timeout, reader.Time("command_timeout_ms"));
    Set(robot.wheel_mm_s, reader.Number("wheel_mm_s", 10, 5000));
    Set(robot.most_mm, reader.Number("most_mm", 50, 1000));
    Set(robot.rest_mm, reader.Number("rest_mm", 0, 50));
    Set(robot.reach_m, reader.Number("reach_m", 0.5, 5));
    Set(robot.grasp_tolerance_mm, reader.Number("grasp_tolerance_mm", 1, 500));
    if (const auto stores = reader.Integer("stores", 0, 20)) {
      robot.stores = static_cast<int>(*stores);
    }
    ReadTimes(reader, "arm", kArmKeys, robot.arm_s);
    ReadTimes(reader, "spear", kSpearKeys, robot.spear_s);
  }

  template <std::size_t N>
  void ReadTimes(TableReader& reader, const char* tool, const std::array<const char*, N>& names,
                 std::array<double, N>& times) {
    keys::Section(reader, tool, findings_, [&](TableReader& table) {
      for (std::size_t i = 0; i < N; ++i)
        Set(times.at(i), table.Number(names.at(i), 0, kLongestToolS));
    });
  }

  void CheckPlace() {
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(field_.cell_m / 2);
    const Eigen::Vector2d least = field_.CentreOf({0, 0}) - half;
    const Eigen::Vector2d most = field_.CentreOf({field_.rows - 1, field_.cols - 1}) + half;
    if ((least - scene_.least_m).minCoeff() < 0 || (scene_.most_m - most).minCoeff() < 0) {
      findings_.Error(at_, "field: the grid reaches beyond the place (x_m and y_m of [place])");
    }
  }

  const Choices& choices_;
  Findings& findings_;
  Scene& scene_;
  FieldSpec field_;
  Position at_;
  std::map<std::string, Position> names_;
  std::map<std::pair<int, int>, std::string> cells_;
};

}  // namespace

void ReadField(TableReader& root, const Choices& choices, Findings& findings, Scene& scene) {
  if (root.Has("field")) return FieldReader(choices, findings, scene).Read(root);
  for (const char* key : {"kfs", "r2", "r1"}) {
    if (!root.Has(key)) continue;
    root.Fault(root.At(key), key, "the scene has no [field]");
  }
}

}  // namespace musher::world
