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

namespace musher::world {
namespace {

using config_toml::Findings;
using config_toml::Position;
using config_toml::Table;
using config_toml::TableReader;
using keys::Coordinate;
using keys::Set;

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
    scene_.name = std::filesystem::path(path).stem().string();
    if (auto name = root.String("name")) scene_.name = name->text;
    if (const auto seed = root.Integer("seed", 0, kMostSeed)) {
      scene_.seed = static_cast<std::uint64_t>(*seed);
    }
    Set(scene_.seed, run_.seed);
    const Choices choices(root, scene_.seed, run_.chosen, findings_);
    scene_.sampled = choices.sampled();
    Set(scene_.speed, root.Number("speed", kLeastSpeed, kMostSpeed));
    Set(scene_.lockstep, root.Bool("lockstep"));
    Section(root, "place", [&](TableReader& reader) { ReadPlace(reader); });
    Section(root, "body", [&](TableReader& reader) { ReadBody(reader); });
    Section(root, "battery", [&](TableReader& reader) { ReadBattery(reader, scene_.battery); });
    Section(root, "picture", [&](TableReader& reader) { ReadPicture(reader); });
    placed_.push_back({scene_.start, {1, 1}, "start"});
    Section(root, "start", [&](TableReader& reader) { ReadStart(reader); });
    const std::string folder = config_toml::FolderOf(path).string();
    ReadThings(root, folder, choices, findings_, scene_);
    scene_.humanoid = ReadHumanoid(root, folder, findings_);
    ReadViews(root, folder, findings_, scene_);
    ReadSensors(root, findings_, scene_.sensors);
    has_field_ = root.Has("field");
    Each(root, "motion", [&](TableReader& reader) { ReadMotion(reader); });
    Each(root, "event", [&](TableReader& reader) { ReadEvent(reader); });
    ReadReferee(root, choices, findings_, scene_);
    const Variation by = ReadVariation(root, findings_);
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
  void Section(TableReader& root, std::string_view key, Read read) {
    keys::Section(root, key, findings_, read);
  }
  template <typename Read>
  void Each(TableReader& root, std::string_view key, Read read) {
    keys::Each(root, key, findings_, read);
  }

  void ReadPlace(TableReader& reader) {
    for (const auto& [key, axis] : {std::pair("x_m", 0), std::pair("y_m", 1)}) {
      const auto range = keys::Range(reader, key, 1);
      if (!range) continue;
      scene_.least_m[axis] = range->x();
      scene_.most_m[axis] = range->y();
    }
    Set(scene_.fence_height_m, keys::Height(reader, "fence_height_m"));
    Set(scene_.ceiling_m, reader.Number("ceiling_m", 0.5, kHighestFlightM));
    Set(scene_.fence_color, keys::ReadColor(reader, "fence_color", findings_));
  }

  void ReadStart(TableReader& reader) {
    Set(scene_.start.position_m.x(), Coordinate(reader, "x_m"));
    Set(scene_.start.position_m.y(), Coordinate(reader, "y_m"));
    Set(scene_.start.yaw_rad, keys::Angle(reader, "yaw_deg"));
    Set(scene_.start_standing, reader.Bool("standing"));
    placed_.back() = {scene_.start, reader.at(), "start"};
  }

  void ReadBody(TableReader& reader) {
    BodySpec& body = scene_.body;
    Set(scene_.has_body, reader.Bool("present"));
    Set(body.radius_m, reader.Number("radius_m", 0.05, 2));
    Set(body.stand_height_m, reader.Number("stand_height_m", 0.1, 2));
    Set(body.lie_height_m, reader.Number("lie_height_m", 0.01, 1));
    Set(body.lag, reader.Time("lag_ms"));
    Set(body.slip, reader.Number("slip", 0, 0.9));
    if (const auto yaw_slip = reader.Number("yaw_slip", 0, 0.9)) body.yaw_slip = yaw_slip;
    Set(body.noise, reader.Number("noise", 0, 0.5));
    Set(body.odometry_scale, reader.Number("odometry_scale", 0.5, 2));
    Set(body.odometry_yaw_drift_rad_per_m,
        keys::Angle(reader, "odometry_yaw_drift_deg_per_m", -45, 45));
    Set(body.command_timeout, reader.Time("command_timeout_ms"));
    if (body.stand_height_m <= body.lie_height_m) {
      reader.Fault(reader.At("stand_height_m"), "stand_height_m",
                   "expected more than lie_height_m, the body would lie when it stands");
    }
  }

  void ReadPicture(TableReader& reader) {
    if (const auto file = reader.String("file")) {
      scene_.picture.file = file->text;
      if (!file->text.ends_with(".png")) {
        reader.Fault(file->at, "file", "expected the name of a .png file");
      }
    }
    Set(scene_.picture.at_teardown, reader.Bool("at_teardown"));
    Set(scene_.picture.scan, reader.Bool("scan"));
    Set(scene_.picture.way, reader.Choice<Picture::Way>("way", {{"state", Picture::Way::kState},
                                                                {"time", Picture::Way::kTime}}));
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
    Set(pose.position_m, keys::Pair(reader, "place_m"));
    Set(pose.yaw_rad, keys::Angle(reader, "yaw_deg"));
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
