#include "musher/modules/world/scene_file/scene_robots.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/modules/world/scene/solids.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"
#include "musher/modules/world/scene_file/scene_sensors.hpp"
#include "musher/modules/world/scene_file/scene_things.hpp"
#include "musher/modules/world/simulation/fleet.hpp"
#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Position;
using config_toml::TableReader;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostW = 10'000;
constexpr double kMostWh = 100'000;
constexpr std::size_t kMostRobots = 50;
constexpr std::size_t kMostObjects = 200;
constexpr std::size_t kMostMovers = 50;
constexpr double kCheckEveryM = 0.05;  // along the way of a mover
// Namespaces of the world's own topics.
constexpr std::array<std::string_view, 5> kReserved{"world", "clock", "map", "musher",
                                                    "map_point_cloud"};
constexpr std::array<Color, 6> kRobotColors{
    {{32, 96, 180}, {206, 96, 20}, {30, 138, 76}, {150, 60, 160}, {190, 40, 60}, {20, 140, 150}}};

class RobotReader {
 public:
  RobotReader(Findings& findings, Scene& scene) : findings_(findings), scene_(scene) {}

  void ReadRobot(TableReader& reader) {
    RobotSpec robot;
    bool flyer = false;
    robot.color = kRobotColors[scene_.robots.size() % kRobotColors.size()];
    keys::ReadSome(
        reader,
        {[&](TableReader& table) { robot.name = TopicName(table); },
         row::Required("kind", "ground or flyer",
                       row::Choice("kind", flyer, {{"ground", false}, {"flyer", true}})),
         [&](TableReader& table) { ReadDrive(table, flyer, robot); },
         keys::Center(robot.start_m.head<2>()),
         keys::Angle("yaw_deg", robot.start_yaw_rad),
         row::Number("radius_m", robot.radius_m, 0.05, 2),
         row::Number("height_m", robot.height_m, 0.05, 3),
         keys::Colour("color", robot.color, findings_),
         row::Time("command_timeout_ms", robot.command_timeout),
         row::Bool("command_stamped", robot.stamped_command),
         row::Number("speed_m_s", robot.limits.speed_m_s, 0.01, 20),
         row::Number("acceleration_m_s2", robot.limits.acceleration_m_s2, 0.05, 100),
         row::Number("turn_rad_s", robot.limits.turn_rad_s, 0.01, 20),
         row::Number("turn_acceleration_rad_s2", robot.limits.turn_acceleration_rad_s2, 0.05, 200),
         row::Sub("battery", BatteryRows(robot.battery)),
         row::Sub("lidar", LidarRows(robot.lidar)),
         [&](TableReader& table) { ReadHand(table, robot); },
         [&](TableReader& table) { ReadCamera(table, robot); },
         [&](TableReader& table) { ReadLineView(table, robot); },
         [&](TableReader& table) { ReadDetector(table, robot); },
         [&](TableReader& table) { ReadRangeDown(table, robot); }});
    written_robots_.push_back({reader.at(), reader.path()});
    scene_.robots.push_back(std::move(robot));
  }

  void ReadObject(TableReader& reader) {
    ObjectSpec object;
    Vector2d at = Vector2d::Zero();
    double bottom = 0;
    object.name = OwnName(reader, object_names_);
    keys::ReadSome(reader,
                   {row::Required("category", "a word such as \"box\"",
                                  row::Text("category", object.category)),
                    keys::Center(at), keys::Angle("yaw_deg", object.yaw_rad),
                    row::Choice("shape", object.round, {{"box", false}, {"cylinder", true}}),
                    row::Number("length_m", object.size_m.x(), keys::kSmallestM, 2),
                    row::Number("width_m", object.size_m.y(), keys::kSmallestM, 2),
                    row::Number("height_m", object.size_m.z(), keys::kSmallestM, 2)});
    if (object.round) {
      if (reader.Has("width_m")) {
        reader.Fault(reader.At("width_m"), "width_m",
                     "a cylinder has none: its length_m is its diameter");
      }
      object.size_m.y() = object.size_m.x();
    }
    keys::ReadSome(
        reader, {keys::Height("bottom_m", bottom), keys::Colour("color", object.color, findings_)});
    object.middle_m = {at.x(), at.y(), bottom + object.size_m.z() / 2};
    written_objects_.push_back({reader.at(), reader.path()});
    scene_.objects.push_back(std::move(object));
  }

  void ReadMover(TableReader& reader) {
    MoverSpec mover;
    mover.name = TopicName(reader);
    reader.Require("points_m", "two points or more, as in [[0, 0], [1.5, -2.0]]");
    const auto points = keys::ReadPoints(reader, "points_m");
    keys::ReadSome(
        reader,
        {row::Choice("way", mover.round_trip, {{"to_and_fro", false}, {"round", true}}),
         row::Number("radius_m", mover.radius_m, 0.05, 2),
         row::Number("height_m", mover.height_m, 0.05, 3),
         row::Number("speed_m_s", mover.speed_m_s, 0.01, 5),
         row::Number("speed_vary", mover.speed_vary, 0, 0.9),
         row::Number("wait_s", mover.wait_s, 0, 3600),
         keys::Colour("color", mover.color, findings_), row::Bool("tracked", mover.tracked)});
    if (!points) return;
    mover.points_m = *points;
    written_movers_.push_back({reader.At("points_m"), reader.path() + ".points_m"});
    scene_.movers.push_back(std::move(mover));
  }

  void Check() {
    if (scene_.robots.size() > kMostRobots) {
      findings_.Error(written_robots_[kMostRobots].at, "expected at most 50 robots");
    }
    if (scene_.objects.size() > kMostObjects) {
      findings_.Error(written_objects_[kMostObjects].at, "expected at most 200 objects");
    }
    if (scene_.movers.size() > kMostMovers) {
      findings_.Error(written_movers_[kMostMovers].at, "expected at most 50 movers");
    }
    if (findings_.HasErrors()) return;
    std::vector<Solid> solids = SolidsOf(scene_);
    for (std::size_t i = 0; i < scene_.movers.size(); ++i) CheckWay(i, solids);
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) CheckObject(i, solids);
    for (std::size_t i = 0; i < scene_.movers.size(); ++i) {
      const Mover mover(scene_.movers[i], 0);
      CheckFree(written_movers_[i], MoverAt(scene_.movers[i], mover.position_m()), solids);
      solids.push_back(SolidOf(scene_.movers[i], mover));
    }
    for (std::size_t i = 0; i < scene_.robots.size(); ++i) {
      const RobotSpec& robot = scene_.robots[i];
      CheckFree(written_robots_[i], CylinderOf(robot, robot.start_m), solids);
      solids.push_back(SolidOf(robot, RobotBody(robot, 0)));
    }
  }

 private:
  // Where it is written in the file, and its name in messages.
  struct Written {
    Position at;
    std::string path;
  };

  void ReadDrive(TableReader& reader, bool flyer, RobotSpec& robot) {
    const auto drive = reader.Choice<RobotKind>(
        "drive",
        {{"holonomic", RobotKind::kHolonomic}, {"differential", RobotKind::kDifferential}});
    robot.kind = flyer ? RobotKind::kFlyer : drive.value_or(RobotKind::kHolonomic);
    if (flyer && reader.Has("drive")) {
      reader.Fault(reader.At("drive"), "drive",
                   "a flyer has none: expected it of a robot on the ground");
    }
    if (flyer) {
      return keys::ReadSome(
          reader, {keys::Height("z_m", robot.start_m.z()),
                   row::Number("climb_m_s", robot.limits.climb_m_s, 0.01, 10),
                   row::Sub("wind", {row::Number("drift_m_s", robot.wind.drift_m_s, 0, 5),
                                     row::Number("gust_s", robot.wind.gust_s, 0.1, 60)})});
    }
    for (const char* key : {"z_m", "climb_m_s", "wind"}) {
      if (reader.Has(key))
        reader.Fault(reader.At(key), key, "a robot on the ground has none: expected it of a flyer");
    }
  }

  static void ReadHand(TableReader& robot_table, RobotSpec& robot) {
    auto reader = robot_table.Sub("hand");
    if (!reader) return;
    HandSpec& hand = robot.hand.emplace();
    ReadRows(*reader, {row::Number("x_m", hand.position_m.x(), -2, 2),
                       row::Number("y_m", hand.position_m.y(), -2, 2),
                       row::Number("z_m", hand.position_m.z(), 0, 3),
                       row::Number("reach_m", hand.reach_m, 0.05, 5)});
  }

  static void ReadCamera(TableReader& robot_table, RobotSpec& robot) {
    auto reader = robot_table.Sub("camera");
    if (!reader) return;
    CameraSpec& camera = robot.camera.emplace();
    camera.position_m = {robot.radius_m, 0, robot.height_m / 2};
    camera.rate_hz = 5;
    ReadRows(*reader, RobotCameraRows(camera));
  }

  static void ReadLineView(TableReader& robot_table, RobotSpec& robot) {
    auto reader = robot_table.Sub("line_view");
    if (!reader) return;
    LineViewSpec& view = robot.line_view.emplace();
    ReadRows(*reader, {row::Number("ahead_m", view.ahead_m, -2, 2),
                       row::Number("width_m", view.width_m, 0.05, 5),
                       row::Number("depth_m", view.depth_m, 0.05, 5)});
  }

  static void ReadDetector(TableReader& robot_table, RobotSpec& robot) {
    auto reader = robot_table.Sub("detector");
    if (!reader) return;
    DetectorSpec& detector = robot.detector.emplace();
    ReadRows(*reader, {row::Number("most_m", detector.most_m, 0.1, keys::kFarthestM),
                       row::Degrees("hfov_deg", detector.hfov_rad, 1, 360),
                       row::Number("rate_hz", detector.rate_hz, 0.1, 50),
                       row::Number("noise_m", detector.noise_m, 0, 1),
                       row::Number("miss_share", detector.miss_share, 0, 1)});
  }

  static void ReadRangeDown(TableReader& robot_table, RobotSpec& robot) {
    auto reader = robot_table.Sub("range_down");
    if (reader) ReadRows(*reader, RangeDownRows(robot.range_down.emplace()));
  }

  std::string OwnName(TableReader& reader, std::map<std::string, Position>& taken) {
    reader.Require("name", config_toml::kNameRule);
    const auto name = reader.String("name");
    if (!name) return "";
    if (!config_toml::IsName(name->text)) {
      reader.Fault(name->at, "name",
                   "expected " + std::string(config_toml::kNameRule) + ", found " +
                       config_toml::Quote(name->text));
    }
    const auto [other, first] = taken.try_emplace(name->text, name->at);
    if (!first) {
      reader.Fault(name->at, "name",
                   config_toml::Quote(name->text) + " is taken, by the one in line " +
                       std::to_string(other->second.line));
    }
    return name->text;
  }

  // Of a robot or mover, whose topics begin with it.
  std::string TopicName(TableReader& reader) {
    std::string name = OwnName(reader, topic_names_);
    if (std::find(kReserved.begin(), kReserved.end(), name) != kReserved.end()) {
      reader.Fault(reader.At("name"), "name",
                   config_toml::Quote(name) + " is the name of topics of the world itself");
    }
    return name;
  }

  static BodyCylinder MoverAt(const MoverSpec& mover, const Vector2d& at) {
    return {{at.x(), at.y(), 0}, mover.radius_m, mover.height_m};
  }

  // Whether the body can be there; else reports why, once.
  bool CheckFree(const Written& written, const BodyCylinder& body,
                 const std::vector<Solid>& solids) {
    const std::string at =
        written.path + ": at " + PointText(body.feet_m.head<2>()) + " it would be ";
    if (!IsWithin(scene_, body)) {
      findings_.Error(written.at, at + "outside the place");
      return false;
    }
    for (const Solid& solid : solids) {
      if (!Overlaps(solid, body)) continue;
      findings_.Error(written.at, at + "in " + solid.what);
      return false;
    }
    return true;
  }

  void CheckWay(std::size_t index, const std::vector<Solid>& fixed) {
    const MoverSpec& mover = scene_.movers[index];
    std::vector<Vector2d> points = mover.points_m;
    if (mover.round_trip) points.push_back(points.front());
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const Vector2d way = points[i + 1] - points[i];
      const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / kCheckEveryM)));
      for (int step = 0; step <= steps; ++step) {
        const Vector2d at = points[i] + way * step / steps;
        if (!CheckFree(written_movers_[index], MoverAt(mover, at), fixed)) return;
      }
    }
  }

  // An object may stand on another one.
  void CheckObject(std::size_t index, std::vector<Solid>& solids) {
    const ObjectSpec& spec = scene_.objects[index];
    const Solid solid = SolidOf(spec, {spec.middle_m, spec.yaw_rad, std::nullopt, 0});
    if (CheckFree(written_objects_[index], CoreOf(solid), solids)) solids.push_back(solid);
  }

  Findings& findings_;
  Scene& scene_;
  std::map<std::string, Position> topic_names_;
  std::map<std::string, Position> object_names_;
  std::vector<Written> written_robots_;
  std::vector<Written> written_objects_;
  std::vector<Written> written_movers_;
};

}  // namespace

config_toml::Rows BatteryRows(BatterySpec& battery) {
  return {
      row::Number("capacity_wh", battery.capacity_wh, 0.01, kMostWh),
      row::Number("start_percent", battery.start_percent, 0, 100),
      row::Number("off_w", battery.off_w, 0, kMostW),
      row::Number("lying_w", battery.lying_w, 0, kMostW),
      row::Number("standing_w", battery.standing_w, 0, kMostW),
      row::Number("moving_w", battery.moving_w, 0, kMostW),
      row::Number("cable_w", battery.cable_w, 0, kMostW),
      row::Number("pad_w", battery.pad_w, 0, kMostW),
  };
}

void ReadRobots(TableReader& root, Findings& findings, Scene& scene) {
  RobotReader robots(findings, scene);
  keys::Each(root, "robot", findings, [&](TableReader& reader) { robots.ReadRobot(reader); });
  keys::Each(root, "object", findings, [&](TableReader& reader) { robots.ReadObject(reader); });
  keys::Each(root, "mover", findings, [&](TableReader& reader) { robots.ReadMover(reader); });
  robots.Check();
}

}  // namespace musher::world
