#include "musher/modules/world/scene_file/scene_field.hpp"

#include <map>
#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/modules/world/body/lift_body.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Position;
using config_toml::Rows;
using config_toml::TableReader;

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
    row::Sub("field", {[&](TableReader& reader) { ReadGrid(reader); }})(root);
    keys::Each(root, "kfs", findings_, [&](TableReader& reader) { ReadBox(reader); });
    const Position robot_at = root.At("r2");
    row::Sub("r2", RobotRows(field_.robot))(root);
    row::Sub("r1",
             {row::Number("ready_after_s", field_.partner.ready_after_s, 0, kLongestToolS)})(root);
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
    keys::ReadSome(reader, {row::Integer("rows", field_.rows, 1, kMostFieldCells),
                            row::Integer("cols", field_.cols, 1, kMostFieldCells),
                            row::Number("cell_m", field_.cell_m, 0.7, 10),
                            keys::Point("origin_m", field_.origin_m)});
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
    keys::ReadSome(reader, {row::Required("kind", "KFS1, KFS2 or fake",
                                          row::Choice("kind", box.kind,
                                                      {{"KFS1", KfsKind::kKfs1},
                                                       {"KFS2", KfsKind::kKfs2},
                                                       {"fake", KfsKind::kFake}})),
                            row::Required("row", "a place in the grid",
                                          row::Integer("row", box.cell.row, 0, field_.rows - 1)),
                            row::Required("col", "a place in the grid",
                                          row::Integer("col", box.cell.col, 0, field_.cols - 1))});
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

  static Rows RobotRows(LiftSpec& robot) {
    return {
        keys::Center(robot.start_m),
        keys::Angle("yaw_deg", robot.start_yaw_rad),
        row::Number("speed_m_s", robot.speed_m_s, 0.01, 5),
        row::Number("acceleration_m_s2", robot.acceleration_m_s2, 0.05, 50),
        row::Number("turn_rad_s", robot.turn_rad_s, 0.01, 10),
        row::Number("turn_acceleration_rad_s2", robot.turn_acceleration_rad_s2, 0.05, 100),
        row::Time("command_timeout_ms", robot.command_timeout),
        row::Number("wheel_mm_s", robot.wheel_mm_s, 10, 5000),
        row::Number("most_mm", robot.most_mm, 50, 1000),
        row::Number("rest_mm", robot.rest_mm, 0, 50),
        row::Number("reach_m", robot.reach_m, 0.5, 5),
        row::Number("grasp_tolerance_mm", robot.grasp_tolerance_mm, 1, 500),
        row::Integer("stores", robot.stores, 0, 20),
        row::Sub("arm", TimeRows(kArmKeys, robot.arm_s)),
        row::Sub("spear", TimeRows(kSpearKeys, robot.spear_s)),
    };
  }

  template <std::size_t N>
  static Rows TimeRows(const std::array<const char*, N>& keys, std::array<double, N>& times_s) {
    Rows rows;
    for (std::size_t i = 0; i < N; ++i) {
      rows.push_back(row::Number(keys.at(i), times_s.at(i), 0, kLongestToolS));
    }
    return rows;
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
