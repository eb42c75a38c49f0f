#include "musher/test/modules/skills/scenes/scene.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::skills::testing {
namespace {

using config_toml::TableReader;

constexpr double kFlightM = 1;  // the height of flights

class SceneReader {
 public:
  explicit SceneReader(TableReader& reader) : reader_(reader) {}

  Scene Read() {
    reader_.Require("name", "the name of the scene");
    reader_.Require("map", "its world, drawn");
    if (const auto name = reader_.String("name")) scene_.name = name->text;
    ReadMap();
    scene_.cell_m = reader_.Number("cell_m", 0.05, 2).value_or(scene_.cell_m);
    scene_.flies = reader_.Bool("flies").value_or(false);
    scene_.map_is_late = reader_.Bool("map_is_late").value_or(false);
    scene_.limit_s = reader_.Number("limit_s", 1, 600).value_or(scene_.limit_s);
    scene_.expects = reader_
                         .Choice<Scene::Expects>("expects", {{"arrives", Scene::Expects::kArrives},
                                                             {"refuses", Scene::Expects::kRefuses},
                                                             {"ends", Scene::Expects::kEnds}})
                         .value_or(scene_.expects);
    for (TableReader& robot : reader_.Subs("robot")) ReadRobot(robot);
    if (scene_.robots.empty()) {
      scene_.robots.push_back({PoseOf('S', 0, reader_), PoseOf('G', 0, reader_), 0});
    }
    for (TableReader& mover : reader_.Subs("mover")) ReadMover(mover);
    for (TableReader& event : reader_.Subs("event")) ReadEvent(event);
    reader_.RefuseOthers();
    return scene_;
  }

 private:
  void ReadMap() {
    const auto map = reader_.String("map");
    if (!map) return;
    std::istringstream lines(map->text);
    std::size_t width = 0;
    for (std::string line; std::getline(lines, line);) {
      if (line.empty()) continue;
      width = std::max(width, line.size());
      scene_.map.push_back(line);
    }
    for (std::string& line : scene_.map) line.resize(width, '#');
    if (scene_.map.empty()) reader_.Fault(map->at, "map", "it is empty");
  }

  navigation::Pose PoseOf(char letter, double yaw_rad, TableReader& reader) {
    for (int y = 0; y < scene_.height(); ++y) {
      for (int x = 0; x < scene_.width(); ++x) {
        if (scene_.At(x, y) != letter) continue;
        const double c = scene_.cell_m;
        return {{(x + 0.5) * c, (y + 0.5) * c, scene_.flies ? kFlightM : 0}, yaw_rad};
      }
    }
    reader.Fault(reader.at(), "map", std::string("there is no place ") + letter);
    return {};
  }

  navigation::Pose PoseOf(TableReader& reader, const char* key, char otherwise, double yaw_rad) {
    const auto place = reader.String(key);
    return PoseOf(place && !place->text.empty() ? place->text[0] : otherwise, yaw_rad, reader);
  }

  void ReadRobot(TableReader& reader) {
    SceneRobot robot;
    const double yaw_rad = reader.Number("yaw_rad", -4, 4).value_or(0);
    robot.start = PoseOf(reader, "start", 'S', yaw_rad);
    robot.goal = PoseOf(reader, "goal", 'G', 0);
    robot.priority = static_cast<int>(reader.Integer("priority", -9, 9).value_or(0));
    reader.RefuseOthers();
    scene_.robots.push_back(robot);
  }

  void ReadMover(TableReader& reader) {
    SceneMover mover;
    reader.Require("path", "its places, as letters of the map");
    const auto path = reader.String("path");
    for (const char letter : path ? path->text : "") {
      mover.path.push_back(PoseOf(letter, 0, reader).at);
    }
    mover.speed_m_s = reader.Number("speed_m_s", 0, 5).value_or(mover.speed_m_s);
    mover.radius_m = reader.Number("radius_m", 0.05, 2).value_or(mover.radius_m);
    mover.height_m = reader.Number("height_m", 0.05, 5).value_or(mover.height_m);
    mover.begins_s = reader.Number("begins_s", 0, 600).value_or(0);
    mover.waits_s = reader.Number("waits_s", 0, 600).value_or(0);
    mover.stays = reader.Bool("stays").value_or(false);
    mover.yields = reader.Bool("yields").value_or(true);
    mover.yields_m = reader.Number("yields_m", 0, 2).value_or(mover.yields_m);
    mover.turns_s = reader.Number("turns_s", 0, 1e9).value_or(mover.turns_s);
    reader.RefuseOthers();
    scene_.movers.push_back(std::move(mover));
  }

  void ReadEvent(TableReader& reader) {
    using Kind = SceneEvent::Kind;
    SceneEvent event;
    reader.Require("kind", "what happens");
    event.kind = reader
                     .Choice<Kind>("kind", {{"jump", Kind::kJump},
                                            {"freeze", Kind::kFreeze},
                                            {"no_odometry", Kind::kNoOdometry},
                                            {"no_scan", Kind::kNoScan},
                                            {"stuck", Kind::kStuck},
                                            {"map", Kind::kMap}})
                     .value_or(event.kind);
    event.at_s = reader.Number("at_s", 0, 600).value_or(0);
    event.lasts_s = reader.Number("lasts_s", 0, 600).value_or(0);
    event.x_m = reader.Number("x_m", -100, 100).value_or(0);
    event.y_m = reader.Number("y_m", -100, 100).value_or(0);
    reader.RefuseOthers();
    scene_.events.push_back(event);
  }

  TableReader& reader_;
  Scene scene_;
};

struct ScenesReading {
  std::optional<std::vector<Scene>> scenes;
  std::vector<Diagnostic> diagnostics;
};

}  // namespace

char Scene::At(int x, int y) const {
  if (x < 0 || y < 0 || x >= width() || y >= height()) return '#';
  return map[static_cast<std::size_t>(height() - 1 - y)][static_cast<std::size_t>(x)];
}

bool Scene::IsWall(int x, int y) const {
  const char at = At(x, y);
  return at == '#' || at == 'x' || at == '%';
}

bool Scene::IsMapped(int x, int y, bool with_late) const {
  const char at = At(x, y);
  return at == '#' || at == 'o' || (with_late && at == '%');
}

Result<std::vector<Scene>> ReadScenes(const std::string& path) {
  const auto read = [](const config_toml::Table& table, config_toml::Findings& findings) {
    TableReader root(table, {1, 1}, "", findings);
    std::vector<Scene> scenes;
    for (TableReader& scene : root.Subs("scene")) scenes.push_back(SceneReader(scene).Read());
    root.RefuseOthers();
    return scenes;
  };
  const auto text = config_toml::ReadModuleText(path);
  if (!text) return text.error();
  auto reading = config_toml::ReadTextWith<ScenesReading>(text.value(), path, read);
  if (!reading.scenes) return Error{kCodeFailed, FormatDiagnostic(reading.diagnostics.front())};
  return *std::move(reading.scenes);
}

}  // namespace musher::skills::testing
