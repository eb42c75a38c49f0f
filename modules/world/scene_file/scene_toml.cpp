#include "musher/modules/world/scene_file/scene_toml.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/world/body/body.hpp"
#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene/variation.hpp"
#include "musher/modules/world/scene_file/scene_course.hpp"
#include "musher/modules/world/scene_file/scene_field.hpp"
#include "musher/modules/world/scene_file/scene_humanoid.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"
#include "musher/modules/world/scene_file/scene_robots.hpp"
#include "musher/modules/world/scene_file/scene_sensors.hpp"
#include "musher/modules/world/scene_file/scene_things.hpp"
#include "musher/transport/lcm_packet.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Position;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr double kLongestS = 1e6;  // eleven days
constexpr std::int64_t kMostSeed = std::int64_t{1} << 62;
constexpr std::int64_t kMostMode = 127;  // what fits into the board's messages

// Scene::start and poses of events: poses that must be free.
struct PlacedPose {
  Pose2 pose;
  Position at;
  std::string what;
};

class Reader {
 public:
  Reader(const SceneRun& run, Findings& findings) : run_(run), findings_(findings) {}

  Scene Read(const Table& table, const std::string& path) {
    TableReader root(table, {1, 1}, "", findings_);
    const std::string folder = config_toml::FolderOf(path).string();
    scene_.name = std::filesystem::path(path).stem().string();
    keys::ReadSome(
        root, {row::Text("name", scene_.name), row::Integer("seed", scene_.seed, 0, kMostSeed)});
    keys::Set(scene_.seed, run_.seed);
    const Choices choices(root, scene_.seed, run_.chosen, findings_);
    scene_.sampled = choices.sampled();
    Variation by;
    placed_.push_back({scene_.start, {1, 1}, "start"});
    keys::ReadSome(root, {row::Number("speed", scene_.speed, kLeastSpeed, kMostSpeed),
                          row::Bool("lockstep", scene_.lockstep),
                          row::Bool("localised", scene_.localised), row::Sub("place", PlaceRows()),
                          row::Sub("body", BodyRows()), row::Sub("motion_board", MotionBoardRows()),
                          row::Sub("battery", BatteryRows(scene_.battery)),
                          row::Sub("picture", PictureRows()), row::Sub("start", StartRows())});
    ReadThings(root, folder, choices, findings_, scene_);
    scene_.humanoid = ReadHumanoid(root, folder);
    ReadViews(root, folder, findings_, scene_);
    keys::ReadSome(root, SensorRows(scene_.sensors));
    has_field_ = root.Has("field");
    Each(root, "motion", [&](TableReader& reader) { ReadMotion(reader); });
    Each(root, "event", [&](TableReader& reader) { ReadEvent(reader); });
    ReadReferee(root, choices, findings_, scene_);
    VariationRow(by)(root);
    ReadRobots(root, findings_, scene_);
    ReadField(root, choices, findings_, scene_);
    ReadGuests(root, findings_, scene_);
    root.RefuseOthers();
    if (!findings_.HasErrors()) CheckPoses();
    if (!findings_.HasErrors()) {
      Vary(by, scene_);
      placed_ = {
          {scene_.start, placed_.front().at, "start, with seed " + std::to_string(scene_.seed)}};
      CheckPoses();
    }
    std::stable_sort(scene_.events.begin(), scene_.events.end(),
                     [](const SceneEvent& a, const SceneEvent& b) { return a.at < b.at; });
    return std::move(scene_);
  }

 private:
  template <typename Read>
  void Each(TableReader& root, std::string_view key, Read read) {
    keys::Each(root, key, findings_, read);
  }

  Rows PlaceRows() {
    const auto range = [this](std::string_view key, int axis) -> Row {
      return [this, key, axis](TableReader& reader) {
        std::optional<Eigen::Vector2d> read;
        keys::Range(key, read, 1)(reader);
        if (!read) return;
        scene_.least_m[axis] = read->x();
        scene_.most_m[axis] = read->y();
      };
    };
    return {range("x_m", 0), range("y_m", 1), keys::Height("fence_height_m", scene_.fence_height_m),
            row::Number("ceiling_m", scene_.ceiling_m, 0.5, kHighestFlightM),
            keys::Colour("fence_color", scene_.fence_color, findings_)};
  }

  Rows StartRows() {
    Pose2& start = scene_.start;
    return {keys::Coordinate("x_m", start.position_m.x()),
            keys::Coordinate("y_m", start.position_m.y()), keys::Angle("yaw_deg", start.yaw_rad),
            row::Bool("standing", scene_.start_standing), [this](TableReader& reader) {
              placed_.back() = {scene_.start, reader.at(), "start"};
            }};
  }

  Rows MotionBoardRows() {
    constexpr int kMostTtl = 255;
    BoardSpec& board = scene_.motion_board;
    return {row::Choice("kind", board.lcm, {{"topic", false}, {"lcm", true}}),
            LcmUrlRow("command_url", board.command_url),
            LcmUrlRow("response_url", board.response_url),
            LcmUrlRow("localization_url", board.localization_url),
            row::Text("interface", board.network_interface),
            row::Integer("ttl", board.ttl, 0, kMostTtl)};
  }

  static Row LcmUrlRow(const char* key, std::string& url) {
    return [key, &url](TableReader& reader) {
      row::Text(key, url)(reader);
      const auto parsed = transport::ReadLcmUrl(url);
      if (!parsed) reader.Fault(reader.At(key), key, parsed.error().message);
    };
  }

  Rows BodyRows() {
    BodySpec& body = scene_.body;
    return {
        row::Bool("present", scene_.has_body),
        row::Number("radius_m", body.radius_m, 0.05, 2),
        row::Number("stand_height_m", body.stand_height_m, 0.1, 2),
        row::Number("lie_height_m", body.lie_height_m, 0.01, 1),
        row::Time("lag_ms", body.lag),
        row::Number("slip", body.slip, 0, 0.9),
        [&body](TableReader& reader) {
          if (const auto yaw_slip = reader.Number("yaw_slip", 0, 0.9)) body.yaw_slip = yaw_slip;
        },
        row::Number("noise", body.noise, 0, 0.5),
        row::Number("odometry_scale", body.odometry_scale, 0.5, 2),
        keys::Angle("odometry_yaw_drift_deg_per_m", body.odometry_yaw_drift_rad_per_m, -45, 45),
        row::Time("command_timeout_ms", body.command_timeout),
        row::Check(
            "stand_height_m", [&body] { return body.stand_height_m > body.lie_height_m; },
            "expected more than lie_height_m, the body would lie when it stands"),
    };
  }

  Rows PictureRows() {
    using Way = Picture::Way;
    return {row::Text("file", scene_.picture.file),
            [this](TableReader& reader) {
              if (!reader.Has("file") || reader.IsFaulty("file")) return;
              if (scene_.picture.file.ends_with(".png")) return;
              reader.Fault(reader.At("file"), "file", "expected the name of a .png file");
            },
            row::Bool("at_teardown", scene_.picture.at_teardown),
            row::Bool("scan", scene_.picture.scan),
            row::Choice("way", scene_.picture.way, {{"state", Way::kState}, {"time", Way::kTime}})};
  }

  void ReadMotion(TableReader& reader) {
    for (const char* key : {"mode", "gait"}) reader.Require(key, "a number of the board's");
    reader.Require("time_ms", "how long it takes");
    const auto mode = reader.Integer("mode", 0, kMostMode);
    const auto gait = reader.Integer("gait", 0, kMostMode);
    const auto time = reader.Time("time_ms");
    if (!mode || !gait || !time) return;
    if (FindMotion(static_cast<int>(*mode), static_cast<int>(*gait)) == nullptr) {
      return reader.Fault(reader.At("mode"), "mode",
                          "the board has no mode " + std::to_string(*mode));
    }
    scene_.motion_times.push_back({static_cast<int>(*mode), static_cast<int>(*gait), *time});
  }

  void ReadEvent(TableReader& reader) {
    reader.Require("at_s", "when it happens, in seconds of world time");
    const double at_s = reader.Number("at_s", 0, kLongestS).value_or(0);
    SceneEvent event;
    event.at = FromSeconds(at_s);
    int found = 0;
    const auto take = [&](auto what) {
      event.what = std::move(what);
      ++found;
    };
    if (reader.Has("battery_percent")) {
      take(ChargeTo{reader.Number("battery_percent", 0, 100).value_or(0)});
    }
    if (reader.Has("cable")) take(Cable{reader.Bool("cable").value_or(false)});
    if (reader.Has("touch")) {
      take(Touch{static_cast<int>(reader.Integer("touch", 1, kMostTouchState).value_or(1))});
    }
    if (reader.Has("fault")) take(ReadFault(reader));
    if (reader.Has("place_m")) take(ReadCarry(reader));
    if (reader.Has("speed")) {
      take(Speed{reader.Number("speed", kLeastSpeed, kMostSpeed).value_or(1)});
    }
    for (const auto& [key, shown] : {std::pair("show", true), std::pair("hide", false)}) {
      if (reader.Has(key)) take(Show{BallName(reader, key), shown});
    }
    if (found != 1) {
      findings_.Error(reader.at(), reader.path() +
                                       ": expected one of battery_percent, cable, touch, fault, "
                                       "place_m, speed, show and hide, found " +
                                       (found == 0 ? "none" : "several"));
    }
    scene_.events.push_back(std::move(event));
  }

  std::string BallName(TableReader& reader, std::string_view key) {
    std::vector<std::pair<std::string_view, std::string_view>> names;
    for (const Ball& ball : scene_.balls) {
      if (!ball.name.empty()) names.emplace_back(ball.name, ball.name);
    }
    if (names.empty()) {
      reader.Fault(reader.At(key), key, "the scene has no [[ball]] with a name");
      return "";
    }
    return std::string(reader.Choice(key, names).value_or(""));
  }

  FaultOn ReadFault(TableReader& reader) {
    std::vector<std::pair<std::string_view, std::string_view>> names;
    for (const FaultKind& fault : Faults()) names.emplace_back(fault.name, fault.name);
    for (const std::string_view fault : kSensorFaults) names.emplace_back(fault, fault);
    if (has_field_) {
      for (const std::string_view fault : kFieldFaults) names.emplace_back(fault, fault);
    }
    const std::string name(reader.Choice("fault", names).value_or("none"));
    const auto motor = reader.Integer("motor", 0, kMotors - 1);
    const FaultKind* fault = FindFault(name);
    if (motor && (fault == nullptr || !fault->of_a_motor)) {
      reader.Fault(reader.At("motor"), "motor", "this fault is of no motor");
    }
    return {name, static_cast<int>(motor.value_or(0))};
  }

  Carry ReadCarry(TableReader& reader) {
    Pose2 pose;
    keys::ReadSome(reader,
                   {keys::Point("place_m", pose.position_m), keys::Angle("yaw_deg", pose.yaw_rad)});
    placed_.push_back({pose, reader.At("place_m"), reader.path() + ".place_m"});
    return {pose};
  }

  void CheckPoses() {
    if (!scene_.has_body) return;
    for (const PlacedPose& placed : placed_) {
      if (IsFree(scene_, placed.pose.position_m)) continue;
      findings_.Error(placed.at, placed.what +
                                     ": the body, a circle of radius_m, cannot be there: "
                                     "it is in an obstacle or outside the place");
    }
  }

  const SceneRun& run_;
  Findings& findings_;
  Scene scene_;
  bool has_field_ = false;
  std::vector<PlacedPose> placed_;
};

// Reads the file of the humanoid's poses, if it names one.
void ReadPoses(SceneReading& reading) {
  if (!reading.scene || !reading.scene->humanoid) return;
  HumanoidSpec& humanoid = *reading.scene->humanoid;
  if (humanoid.poses_file.empty()) return;
  PosesReading poses = ReadPosesFile(humanoid.poses_file);
  std::move(poses.diagnostics.begin(), poses.diagnostics.end(),
            std::back_inserter(reading.diagnostics));
  if (poses.poses) {
    humanoid.poses = std::move(*poses.poses);
  } else {
    reading.scene.reset();
  }
}

}  // namespace

SceneReading ReadSceneText(std::string_view text, const std::string& path, const SceneRun& run) {
  auto reading = config_toml::ReadTextWith<SceneReading>(
      text, path, [&](const Table& root, Findings& findings) {
        return Reader(run, findings).Read(root, path);
      });
  ReadPoses(reading);
  return reading;
}

SceneReading ReadSceneFile(const std::string& path, const SceneRun& run) {
  return config_toml::ReadFileWith(path, [&](std::string_view text, const std::string& at) {
    return ReadSceneText(text, at, run);
  });
}

}  // namespace musher::world
