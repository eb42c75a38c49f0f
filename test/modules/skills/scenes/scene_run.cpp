#include "musher/test/modules/skills/scenes/scene_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

#include "musher/base/check.hpp"
#include "musher/behavior/skill/manager.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/navigation/controller_server/controller_server.hpp"
#include "musher/modules/navigation/planner_server/planner_server.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/skills/body_skills.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"
#include "musher/test/modules/navigation/servers_on_network.hpp"
#include "musher/test/modules/skills/scenes/scene_world.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::skills::testing {
namespace {

using navigation::testing::ServersOnNetwork;
using End = RobotOutcome::End;

constexpr double kRangeM = 8;
constexpr double kMapM = 0.05;    // a cell of the map
constexpr double kWallsM = 2.4;   // their height, for flyers
constexpr double kPointsM = 0.1;  // between two points of them

template <class T>
T Value(Result<T> result) {
  MUSHER_CHECK(result.ok(), result.error().message);
  return std::move(result).value();
}

std::string NameOf(std::size_t robot) {
  return "robot_" + std::to_string(robot);
}

// Lets everything pass: nothing is near enough, and nothing is unknown.
void Disable(navigation::GateRules& gate, double radius_m) {
  gate.margin_m = -radius_m;
  gate.blind_m_s = gate.unknown_m_s = 100;
}

msg::OccupancyGrid GridOf(const Scene& scene, bool with_late) {
  const int cells = std::max(1, static_cast<int>(std::lround(scene.cell_m / kMapM)));
  msg::OccupancyGrid grid;
  grid.header.frame_id = "map";
  grid.info.resolution = static_cast<float>(scene.cell_m / cells);
  grid.info.width = static_cast<std::uint32_t>(scene.width() * cells);
  grid.info.height = static_cast<std::uint32_t>(scene.height() * cells);
  grid.info.origin.orientation.w = 1;
  for (int y = 0; y < scene.height() * cells; ++y) {
    for (int x = 0; x < scene.width() * cells; ++x) {
      grid.data.push_back(scene.IsMapped(x / cells, y / cells, with_late) ? 100 : 0);
    }
  }
  return grid;
}

msg::PointCloud2 CloudOf(const Scene& scene, bool with_late) {
  std::vector<float> values;
  const int points = std::max(1, static_cast<int>(std::lround(scene.cell_m / kPointsM)));
  const double step_m = scene.cell_m / points;
  for (int y = 0; y < scene.height() * points; ++y) {
    for (int x = 0; x < scene.width() * points; ++x) {
      if (!scene.IsMapped(x / points, y / points, with_late)) continue;
      for (double z_m = kPointsM / 2; z_m < kWallsM; z_m += kPointsM) {
        for (const double value : {(x + 0.5) * step_m, (y + 0.5) * step_m, z_m}) {
          values.push_back(static_cast<float>(value));
        }
      }
    }
  }
  msg::PointCloud2 cloud;
  cloud.header.frame_id = "map";
  cloud.height = 1;
  cloud.point_step = 12;
  cloud.width = static_cast<std::uint32_t>(values.size() / 3);
  cloud.row_step = cloud.width * 12;
  for (std::uint32_t i = 0; i < 3; ++i) {
    cloud.fields.push_back(
        {std::string(1, static_cast<char>('x' + i)), 4 * i, msg::PointField::kFloat32, 1});
  }
  cloud.data.resize(cloud.row_step);
  std::memcpy(cloud.data.data(), values.data(), cloud.data.size());
  return cloud;
}

// The process musher-skills of one robot.
class SkillsOfScene {
 public:
  SkillsOfScene(transport::Node& node, const SkillsConfig& config)
      : robot_(config), endpoints_(node, "") {
    robot_.Open(endpoints_, "");
    skill::Registry registry;
    MUSHER_CHECK(RegisterNavigationSkills(registry, robot_).ok());
    MUSHER_CHECK(RegisterBodySkills(registry, robot_).ok());
    manager_ = std::make_unique<skill::Manager>(registry.All());
    ticks_ = node.loop().Every(Milliseconds(100), [this, &node] {
      robot_.BeginStep(node.loop().Now());
      manager_->RunOnce(node.loop().Now());
    });
  }
  void Start(const std::string& skill, const skill::Values& parameters) {
    skill_ = skill;
    const auto started = manager_->Start(skill, parameters);
    MUSHER_CHECK(started.ok(), started.error().message);
  }
  void GoTo(const navigation::Point& goal) {
    Start("navigate_to", {{"goal_pos", skill::Numbers{goal.x_m, goal.y_m, goal.z_m}}});
  }
  const skill::Run& run() const { return *manager_->Find(skill_); }

 private:
  RosRobot robot_;
  transport::Endpoints endpoints_;
  std::unique_ptr<skill::Manager> manager_;
  std::string skill_;
  transport::LoopHandlePtr ticks_;
};

// Which of the free places of a world a robot has come near to, on a raster.
class CoveredArea {
 public:
  CoveredArea(const Scene& scene, double within_m) : scene_(scene), within_m_(within_m) {
    for (double y = kRasterM / 2; y < scene.height() * scene.cell_m; y += kRasterM) {
      for (double x = kRasterM / 2; x < scene.width() * scene.cell_m; x += kRasterM) {
        const auto cell = [&](double at) { return static_cast<int>(at / scene_.cell_m); };
        if (!scene.IsWall(cell(x), cell(y))) left_.push_back({x, y, 0});
      }
    }
    all_ = left_.size();
  }
  void Note(const navigation::Point& at) {
    std::erase_if(left_, [&](const navigation::Point& place) {
      return std::hypot(place.x_m - at.x_m, place.y_m - at.y_m) <= within_m_;
    });
  }
  double free_m2() const { return static_cast<double>(all_) * kRasterM * kRasterM; }
  double share() const {
    return 1 -
           static_cast<double>(left_.size()) / static_cast<double>(std::max<std::size_t>(all_, 1));
  }

 private:
  static constexpr double kRasterM = 0.05;

  const Scene& scene_;
  const double within_m_;
  std::vector<navigation::Point> left_;
  std::size_t all_ = 0;
};

class SceneRun {
 public:
  SceneRun(const Scene& scene, bool gated, std::uint64_t seed)
      : scene_(scene), network_(seed), world_(scene, seed) {
    StartServers(gated);
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      nodes_.push_back(network_.MakeNode("robot"));
      skills_.push_back(std::make_unique<SkillsOfScene>(*nodes_.back(), ConfigOf(i, gated)));
      peers_.push_back(std::make_unique<Peer>(*this, i));
    }
    if (scene.flies) {
      cloud_ = Value(transport::MakePublisher<msg::PointCloud2>(*node_, "map_point_cloud",
                                                                transport::kLatchedQos));
    } else {
      grid_ = Value(
          transport::MakePublisher<msg::OccupancyGrid>(*node_, "map", transport::kLatchedQos));
    }
    if (!scene.map_is_late) PublishMap(false);
    timers_.push_back(node_->loop().Every(Milliseconds(10), [this] {
      if (begun_) world_.Step(0.01);
    }));
    network_.RunFor(Milliseconds(2000));  // discovery, the distances of the map
  }

  Exploration Explore(double lane_width_m) {
    Begin();
    const Time begin = network_.now();
    const double c = scene_.cell_m, x_m = scene_.width() * c - c, y_m = scene_.height() * c - c;
    const auto corner = [](double x, double y) {
      return "[" + std::to_string(x) + ", " + std::to_string(y) + "]";
    };
    skills_[0]->Start("explore", {{"boundary", "[" + corner(c, c) + ", " + corner(x_m, c) + ", " +
                                                   corner(x_m, y_m) + ", " + corner(c, y_m) + "]"},
                                  {"lane_width", lane_width_m}});
    CoveredArea covered(scene_, lane_width_m / 2);
    while (network_.now() < begin + FromSeconds(scene_.limit_s) && !skills_[0]->run().ended()) {
      network_.RunFor(Milliseconds(100));
      covered.Note(world_.pose(0).at);
    }
    return {covered.free_m2(), covered.share(), ToSeconds(network_.now() - begin),
            skills_[0]->run().feedback().message, world_.contacts(0)};
  }

  SceneOutcome Run() {
    Begin();
    const Time begin = network_.now();
    for (std::size_t i = 0; i < skills_.size(); ++i) skills_[i]->GoTo(scene_.robots[i].goal.at);
    SceneOutcome outcome;
    outcome.robots.resize(skills_.size());
    const Time deadline = begin + FromSeconds(scene_.limit_s);
    while (network_.now() < deadline && !NoteEnds(outcome, begin)) {
      network_.RunFor(Milliseconds(100));
    }
    if (scene_.lands) LandAll(outcome);
    network_.RunFor(Milliseconds(2000));  // they roll out
    for (std::size_t i = 0; i < skills_.size(); ++i) {
      const navigation::Velocity velocity = world_.velocity(i);
      RobotOutcome& robot = outcome.robots[i];
      robot.stands = navigation::Speed(velocity) < 0.1 && std::abs(velocity.yaw_rad_s) < 0.1;
      robot.contacts = world_.contacts(i);
      robot.from_above = world_.from_above(i);
      robot.travelled_m = world_.travelled_m(i);
      robot.least_room_m = world_.least_room_m(i);
    }
    outcome.hits_of_movers = world_.hits_of_movers();
    return outcome;
  }

 private:
  void Begin() {
    begun_ = true;
    for (const SceneEvent& event : scene_.events) {
      if (event.kind != SceneEvent::Kind::kMap) continue;
      timers_.push_back(
          node_->loop().At(network_.now() + FromSeconds(event.at_s), [this] { PublishMap(true); }));
    }
  }

  // What a robot's body publishes and subscribes to.
  struct Peer {
    Peer(SceneRun& run, std::size_t index) {
      transport::Node& node = *run.node_;
      const std::string name = NameOf(index);
      odometry = Value(transport::MakePublisher<msg::Odometry>(node, name + "/odom"));
      scan = Value(transport::MakePublisher<msg::LaserScan>(node, name + "/scan"));
      if (run.scene_.looks_down) {
        range = Value(transport::MakePublisher<msg::Range>(node, name + "/range_down"));
        timers.push_back(node.loop().Every(Milliseconds(50),
                                           [&run, index, this] { run.LookDown(*this, index); }));
      }
      commands = Value(transport::MakeSubscription<msg::Twist>(
          node, name + "/cmd_vel", [&run, index, this](const msg::Twist& twist, const auto&) {
            command_at = run.network_.now();
            run.world_.Command(index,
                               {twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z});
          }));
      timers.push_back(
          node.loop().Every(Milliseconds(20), [&run, index, this] { run.Report(*this, index); }));
      timers.push_back(
          node.loop().Every(Milliseconds(100), [&run, index, this] { run.Look(*this, index); }));
    }
    std::unique_ptr<transport::Publisher<msg::Odometry>> odometry;
    std::unique_ptr<transport::Publisher<msg::LaserScan>> scan;
    std::unique_ptr<transport::Publisher<msg::Range>> range;
    std::unique_ptr<transport::Subscription> commands;
    std::optional<navigation::Pose> frozen;
    Time command_at{};
    std::vector<transport::LoopHandlePtr> timers;
  };

  static std::string DownKeys(const std::string& robot) {
    const std::string foot = std::to_string(kSceneBodyHeightM);
    return "topic = \"" + robot + "/range_down\"\nz_m = -" + foot + "\nfoot_m = " + foot + "\n";
  }

  static std::string RobotTables(const Scene& scene, bool with_gate) {
    std::string tables = "self_check_ms = 15000\n";
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      tables += "[[robot]]\nname = \"" + NameOf(i) + "\"\n";
      if (scene.flies) tables += "kind = \"flyer\"\n";
      if (with_gate && scene.looks_down)
        tables += "[robot.gate]\n[robot.gate.down]\n" + DownKeys(NameOf(i));
    }
    return tables;
  }

  void StartServers(bool gated) {
    const auto planner = navigation::ReadPlannerText(RobotTables(scene_, false), "planner.toml");
    auto controller = navigation::ReadControllerText(RobotTables(scene_, true), "controller.toml");
    MUSHER_CHECK(planner.config && controller.config);
    for (navigation::ControllerRobot& robot : controller.config->robots) {
      if (!gated) Disable(robot.gate, robot.radius_m);
    }
    servers_.Start(*planner.config, *controller.config);
  }

  SkillsConfig ConfigOf(std::size_t index, bool gated) const {
    const SceneRobot& robot = scene_.robots[index];
    std::string text = "robot = \"" + NameOf(index) +
                       "\"\nradius_m = 0.2\npriority = " + std::to_string(robot.priority) + "\n";
    text +=
        scene_.flies ? "kind = \"cf2x\"\nflies = true\nceiling_m = 2.2\n" : "kind = \"jetbot\"\n";
    text += "[topics]\nobjects = \"\"\n";
    if (scene_.looks_down) text += "[gate.down]\n" + DownKeys(NameOf(index));
    auto reading = ReadSkillsText(text, "/tmp/robot.toml");
    MUSHER_CHECK(reading.config.has_value());
    if (!gated) Disable(reading.config->gate, reading.config->radius_m);
    return *std::move(reading.config);
  }

  void PublishMap(bool with_late) {
    if (grid_) static_cast<void>(grid_->Publish(GridOf(scene_, with_late)));
    if (cloud_) static_cast<void>(cloud_->Publish(CloudOf(scene_, with_late)));
  }

  msg::Header HeaderNow() const {
    msg::Header header;
    header.stamp = msg::ToStamp(network_.now().time_since_epoch());
    header.frame_id = "map";
    return header;
  }

  void Report(Peer& peer, std::size_t index) {
    constexpr Duration kDeadMan = Milliseconds(500);
    if (network_.now() - peer.command_at > kDeadMan) world_.Command(index, {});
    if (world_.Holds(SceneEvent::Kind::kNoOdometry)) return;
    navigation::Pose pose = world_.pose(index);
    const navigation::Point off = world_.JumpNow();
    pose.at.x_m += off.x_m;
    pose.at.y_m += off.y_m;
    if (!world_.Holds(SceneEvent::Kind::kFreeze)) peer.frozen = pose;
    msg::Odometry odometry;
    odometry.header = HeaderNow();
    odometry.child_frame_id = NameOf(index);
    odometry.pose.pose = navigation::ToMessage(peer.frozen.value_or(pose));
    const navigation::Velocity velocity = world_.velocity(index);
    odometry.twist.twist.linear = {velocity.x_m_s, velocity.y_m_s, velocity.z_m_s};
    odometry.twist.twist.angular.z = velocity.yaw_rad_s;
    static_cast<void>(peer.odometry->Publish(odometry));
  }

  void Look(Peer& peer, std::size_t index) {
    if (world_.Holds(SceneEvent::Kind::kNoScan)) return;
    msg::LaserScan scan;
    scan.header = HeaderNow();
    scan.ranges = world_.Look(index, kRangeM);
    scan.angle_increment = static_cast<float>(2 * M_PI / static_cast<double>(scan.ranges.size()));
    scan.angle_max = static_cast<float>(2 * M_PI) - scan.angle_increment;
    scan.range_min = 0.02F;
    scan.range_max = static_cast<float>(kRangeM) - 0.01F;
    static_cast<void>(peer.scan->Publish(scan));
  }

  void LookDown(Peer& peer, std::size_t index) {
    msg::Range range;
    range.header = HeaderNow();
    range.field_of_view = static_cast<float>(kSceneConeRad);
    range.min_range = 0.02F;
    range.max_range = static_cast<float>(kSceneDownM);
    range.range = static_cast<float>(world_.LookDown(index));
    static_cast<void>(peer.range->Publish(range));
  }

  // Those that fly land, one after another as their drives have ended.
  void LandAll(SceneOutcome& outcome) {
    const Duration longest = std::chrono::seconds(scene_.aside_m > 0 ? 180 : 60);
    for (const auto& skills : skills_) skills->Start("land", {{"aside", scene_.aside_m}});
    const Time deadline = network_.now() + longest;
    const auto lands = [](const auto& skills) { return !skills->run().ended(); };
    while (network_.now() < deadline && std::ranges::any_of(skills_, lands)) {
      network_.RunFor(Milliseconds(100));
    }
    for (std::size_t i = 0; i < skills_.size(); ++i) {
      const skill::Feedback& end = skills_[i]->run().feedback();
      outcome.robots[i].landed = end.status == skill::Status::kCompleted;
      outcome.robots[i].landing = end.message;
    }
  }

  // True: all have ended.
  bool NoteEnds(SceneOutcome& outcome, Time begin) const {
    bool all = true;
    for (std::size_t i = 0; i < skills_.size(); ++i) {
      RobotOutcome& robot = outcome.robots[i];
      if (robot.end != End::kOpen) continue;
      const skill::Run& run = skills_[i]->run();
      robot.message = run.feedback().message;
      if (!run.ended()) {
        all = false;
        continue;
      }
      const bool moved = world_.travelled_m(i) > 0.1;
      robot.end = run.feedback().status == skill::Status::kCompleted       ? End::kArrived
                  : robot.message.starts_with("Planning failed") && !moved ? End::kRefused
                                                                           : End::kFailed;
      robot.seconds = ToSeconds(network_.now() - begin);
      const navigation::Point& at = world_.pose(i).at;
      const navigation::Point& goal = scene_.robots[i].goal.at;
      robot.off_goal_m = std::hypot(at.x_m - goal.x_m, at.y_m - goal.y_m);
    }
    return all;
  }

  const Scene& scene_;
  transport::sim::Network network_;
  SceneWorld world_;
  bool begun_ = false;
  ServersOnNetwork servers_{network_};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");  // of the bodies
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> grid_;
  std::unique_ptr<transport::Publisher<msg::PointCloud2>> cloud_;
  std::vector<std::unique_ptr<transport::Node>> nodes_;
  std::vector<std::unique_ptr<SkillsOfScene>> skills_;
  std::vector<std::unique_ptr<Peer>> peers_;
  std::vector<transport::LoopHandlePtr> timers_;
};

}  // namespace

int SceneOutcome::Count(End end) const {
  return static_cast<int>(std::ranges::count(robots, end, &RobotOutcome::end));
}

int SceneOutcome::contacts() const {
  int all = 0;
  for (const RobotOutcome& robot : robots) all += robot.contacts;
  return all;
}

double SceneOutcome::seconds() const {
  double last_s = 0;
  for (const RobotOutcome& robot : robots) last_s = std::max(last_s, robot.seconds);
  return last_s;
}

Exploration RunExploration(const Scene& scene, double lane_width_m, std::uint64_t seed) {
  return SceneRun(scene, true, seed).Explore(lane_width_m);
}

SceneOutcome RunScene(const Scene& scene, bool gated, std::uint64_t seed) {
  return SceneRun(scene, gated, seed).Run();
}

}  // namespace musher::skills::testing
