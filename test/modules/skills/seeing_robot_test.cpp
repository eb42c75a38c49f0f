// visual_servoing and assembly in a whole scene: the world with its bodies, its detector and its
// count of collisions, and the skills behind topics and gate, in virtual time. Between detector and
// skills is a relay that injects faults: pictures that are lost, stand, or show a second thing or
// one that jumps. The base is commanded only while single sightings come, and nothing is touched.

#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "musher/behavior/skill/manager.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/musher_msgs/manipulation.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/skills/body_skills.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/modules/world/rooms.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::seeing_robot_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

constexpr const char* kRobot = "jetbot_0";

// The yard with a robot that has a detector, in the middle, and a dock.
world::Scene Yard(double dock_x_m, double dock_y_m) {
  world::Scene scene = world::RobotYard();
  scene.robots.resize(1);
  scene.robots[0].lidar.mount.position_m.z() = 0.06;
  scene.robots[0].lidar.reach.noise_m = 0.005;
  scene.robots[0].detector = world::DetectorSpec{.miss_share = 0.1};
  world::ObjectSpec dock = world::BoxOf("dock", {dock_x_m, dock_y_m, 0.1});
  dock.category = "station";
  dock.size_m = {0.3, 0.3, 0.2};
  scene.objects = {dock};
  return scene;
}

class SeeingRobot {
 public:
  explicit SeeingRobot(const world::Scene& scene) : robot_(Config()), endpoints_(*node_, "") {
    host_ = world::WorldHost::Start(*world_node_, scene, {}).value();
    seen_ = transport::MakePublisher<msg::ObjectStates>(*desk_, "seen", transport::kSensorDataQos)
                .value();
    relay_ = transport::MakeSubscription<msg::ObjectStates>(
                 *desk_, std::string(kRobot) + "/detections",
                 [this](const msg::ObjectStates& found, const auto&) { Relay(found); },
                 transport::kSensorDataQos)
                 .value();
    commands_ = transport::MakeSubscription<msg::Twist>(
                    *desk_, std::string(kRobot) + "/cmd_vel",
                    [this](const msg::Twist& twist, const auto&) { OnCommand(twist); })
                    .value();
    robot_.Open(endpoints_, "");
    skill::Registry registry;
    EXPECT_TRUE(RegisterNavigationSkills(registry, robot_));
    EXPECT_TRUE(RegisterBodySkills(registry, robot_));
    manager_ = std::make_unique<skill::Manager>(registry.All());
    steps_ = node_->loop().Every(Milliseconds(100), [this] {
      robot_.BeginStep(node_->loop().Now());
      manager_->RunOnce(node_->loop().Now());
    });
    RunFor(1);
  }

  void RunFor(double seconds) { network_.RunFor(FromSeconds(seconds)); }
  void Start(const std::string& skill, const Texts& parameters) {
    skill_ = skill;
    const auto started = manager_->StartWithTexts(skill, parameters);
    EXPECT_TRUE(started) << started.error().message;
  }
  // Until its end, or for so long; then until the robot stands.
  std::string End(
      double seconds, const std::function<void(double)>& each = [](double) {}) {
    for (double at_s = 0; at_s < seconds && !run().ended(); at_s += 0.5) {
      each(at_s);
      RunFor(0.5);
    }
    EXPECT_TRUE(run().ended()) << run().feedback().message;
    RunFor(1.5);
    return run().feedback().message;
  }
  bool completed() const { return run().feedback().status == skill::Status::kCompleted; }
  const skill::Run& run() const { return *manager_->Find(skill_); }
  world::World world() const { return host_->world(); }
  void SendOdometryFault(const std::string& text) {
    auto fault =
        transport::MakePublisher<msg::String>(*desk_, "world/" + std::string(kRobot) + "/odometry")
            .value();
    RunFor(0.2);
    EXPECT_TRUE(fault->Publish({text}));
    RunFor(0.1);
  }

  enum class Fault : std::uint8_t { kNone, kSilent, kStands, kDoubled, kJumps, kBlind };
  Fault fault = Fault::kNone;
  // The longest time from a sighting that counts to a command that moves the base, s.
  double longest_blind_s = 0;
  int moves = 0;

 private:
  static skills::SkillsConfig Config() {
    const auto reading = skills::ReadSkillsText(
        "robot = \"jetbot_0\"\nkind = \"jetbot\"\nradius_m = 0.2\nhand = true\n[topics]\n"
        "detections = \"seen\"\n",
        "/tmp/r.toml");
    return *reading.config;
  }

  void Relay(msg::ObjectStates found) {
    switch (fault) {
      case Fault::kSilent:
        return;
      case Fault::kStands:
        found = last_;
        break;
      case Fault::kDoubled:
        if (!found.objects.empty()) {
          found.objects.push_back(found.objects.front());
          found.objects.back().pose.position.y += 1;
        }
        break;
      case Fault::kJumps:
        for (auto& object : found.objects) object.pose.position.y += 4;
        // Once it was not seen for long, it may be there.
        if (found.objects.size() == 1) counted_at_ = desk_->loop().Now();
        break;
      case Fault::kBlind:
        found.objects.clear();
        break;
      case Fault::kNone:
        last_ = found;
        if (found.objects.size() == 1) counted_at_ = desk_->loop().Now();
    }
    EXPECT_TRUE(seen_->Publish(found));
  }
  void OnCommand(const msg::Twist& twist) {
    if (twist.linear.x == 0 && twist.angular.z == 0) return;
    ++moves;
    longest_blind_s = std::max(longest_blind_s, ToSeconds(desk_->loop().Now() - counted_at_));
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> world_node_ = network_.MakeNode("world");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("world");
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<world::WorldHost> host_;
  msg::ObjectStates last_;
  Time counted_at_{};
  std::string skill_;
  std::unique_ptr<transport::Publisher<msg::ObjectStates>> seen_;
  std::unique_ptr<transport::Subscription> relay_;
  std::unique_ptr<transport::Subscription> commands_;
  skills::RosRobot robot_;
  transport::Endpoints endpoints_;
  std::unique_ptr<skill::Manager> manager_;
  transport::LoopHandlePtr steps_;
};

using Fault = SeeingRobot::Fault;

// 300 ms by the skill, up to a step of it, and the messages on their way.
constexpr double kLongestBlindS = 0.5;

double DistanceTo(const world::World& world, std::size_t object) {
  const Eigen::Vector3d between =
      world.fleet().objects()[object].middle_m - world.fleet().robots()[0].body.position_m();
  return between.head<2>().norm();
}

double SpeedOf(const world::World& world) {
  return world.fleet().robots()[0].body.velocity().linear_m_s.norm();
}

TEST(ASeeingRobot, StandsBeforeTheDockAtTheDistance) {
  SeeingRobot robot(Yard(3, 1));
  robot.Start("visual_servoing", {{"target", "dock"}, {"distance", "0.7"}, {"bearing", "0.3"}});
  EXPECT_EQ(robot.End(70), "Reached dock");
  const world::World world = robot.world();
  EXPECT_NEAR(DistanceTo(world, 0), 0.7, 0.07);
  EXPECT_EQ(world.fleet().robots()[0].collisions, 0);
  EXPECT_LT(robot.longest_blind_s, kLongestBlindS);
  EXPECT_GT(robot.moves, 20);
}

TEST(ASeeingRobot, StandsAndFailsWithTheReasonWhenTheDetectorFails) {
  const std::pair<Fault, std::string> faults[] = {
      {Fault::kSilent, "dock is not seen for "}, {Fault::kStands, "dock is not seen for "},
      {Fault::kBlind, "dock is not seen for "},  {Fault::kDoubled, "2 things are dock"},
      {Fault::kJumps, "dock has jumped by "},
  };
  for (const auto& [fault, why] : faults) {
    SeeingRobot robot(Yard(3.5, 0.5));
    robot.Start("visual_servoing", {{"target", "dock"}});
    robot.RunFor(4);
    EXPECT_GT(SpeedOf(robot.world()), 0.05) << why;
    robot.fault = fault;
    robot.RunFor(1);
    const world::World stood = robot.world();
    EXPECT_LT(SpeedOf(stood), 0.01) << why;
    const std::string end = robot.End(10);
    EXPECT_TRUE(end.starts_with(why) || end == "no detections on seen") << end;
    EXPECT_NEAR(DistanceTo(robot.world(), 0), DistanceTo(stood, 0), 0.01) << why;
    EXPECT_EQ(robot.world().fleet().robots()[0].collisions, 0);
    EXPECT_LT(robot.longest_blind_s, kLongestBlindS) << why;
  }
}

TEST(ASeeingRobot, DoesNotGoToADockBehindAWall) {
  world::Scene scene = Yard(3, 0);
  world::Box wall;
  wall.name = "wall";
  wall.center_m = {1.5, 0};
  wall.half_m = {0.05, 1};
  wall.height_m = 1;
  scene.boxes.push_back(wall);
  SeeingRobot robot(scene);
  robot.Start("visual_servoing", {{"target", "dock"}});
  EXPECT_EQ(robot.End(10), "dock is not seen");
  EXPECT_EQ(robot.moves, 0);
}

TEST(ASeeingRobot, IsStoppedByTheGateBeforeWhatItDoesNotDetect) {
  world::Scene scene = Yard(3, 0);
  world::Box low;  // seen by the lidar; the dock is seen over it
  low.name = "sill";
  low.center_m = {1.2, 0};
  low.half_m = {0.1, 1};
  low.height_m = 0.1;
  scene.boxes.push_back(low);
  scene.objects[0].size_m.z() = 0.6;
  scene.objects[0].middle_m.z() = 0.3;
  SeeingRobot robot(scene);
  robot.Start("visual_servoing", {{"target", "dock"}});
  EXPECT_THAT(robot.End(40), StartsWith("Blocked: "));
  EXPECT_EQ(robot.world().fleet().robots()[0].collisions, 0);
}

TEST(ASeeingRobot, GoesToTheCarInTheRooms) {
  const auto reading = world::ReadSceneFile(SourceDir() + "/config/scenes/rooms.toml");
  ASSERT_TRUE(reading.scene);
  world::Scene scene = *reading.scene;
  scene.robots[0].start_m = {1.8, 5.8, 0};
  scene.robots[0].start_yaw_rad = 0;
  SeeingRobot robot(scene);
  robot.Start("visual_servoing", {{"target", "car"}, {"distance", "0.8"}});
  EXPECT_EQ(robot.End(70), "Reached car");
  const world::World world = robot.world();
  EXPECT_NEAR(DistanceTo(world, 3), 0.8, 0.07);
  EXPECT_EQ(world.fleet().robots()[0].collisions, 0);
}

TEST(ASeeingRobot, AssemblesAPartThatItHasPickedUp) {
  world::Scene scene = Yard(2.5, 0.6);
  world::ObjectSpec gear = world::BoxOf("gear", {0.7, -0.5, 0.05});
  gear.size_m = {0.1, 0.1, 0.1};
  scene.objects.push_back(gear);
  SeeingRobot robot(scene);
  robot.Start("pick_up", {{"object_prim_path", "gear"}});
  EXPECT_EQ(robot.End(10), "Object picked up");
  robot.Start("assembly", {{"station", "dock"}, {"offset", "[0.05, 0, 0.1]"}});
  EXPECT_EQ(robot.End(80), "Assembled: gear stands at dock");
  const world::World world = robot.world();
  const Eigen::Vector3d between =
      world.fleet().objects()[1].middle_m - world.fleet().objects()[0].middle_m;
  EXPECT_NEAR(between.x(), 0.05, 0.03);
  EXPECT_NEAR(between.y(), 0, 0.03);
  EXPECT_NEAR(between.z(), 0.15, 0.001);
  EXPECT_EQ(world.fleet().robots()[0].collisions, 0);
}

TEST(ASeeingRobot, NoticesThatAPartHasFallenBesideTheStation) {
  world::Scene scene = Yard(2.2, 0.3);
  world::ObjectSpec gear = world::BoxOf("gear", {0.7, -0.5, 0.05});
  gear.size_m = {0.1, 0.1, 0.1};
  scene.objects.push_back(gear);
  SeeingRobot robot(scene);
  robot.Start("pick_up", {{"object_prim_path", "gear"}});
  robot.End(10);
  // The offset is beside the dock, so that it falls to the ground.
  robot.Start("assembly", {{"station", "dock"}, {"offset", "[0, -0.35, 0.1]"}});
  EXPECT_THAT(robot.End(80), HasSubstr("gear has fallen: it is 0."));
  EXPECT_FALSE(robot.completed());
}

// Random yards and faults, one after the other; the dock is somewhere ahead.
void ExpectNoContact(std::uint64_t from, std::uint64_t to) {
  int reached = 0, failed = 0;
  for (std::uint64_t seed = from; seed < to; ++seed) {
    std::mt19937_64 random(seed);
    const auto between = [&](double least, double most) {
      return std::uniform_real_distribution<double>(least, most)(random);
    };
    const double away_m = between(1, 3.6), bearing_rad = between(-0.5, 0.5);
    world::Scene scene = Yard(away_m * std::cos(bearing_rad), away_m * std::sin(bearing_rad));
    scene.seed = seed;
    for (int i = 0; i < 12; ++i) {
      world::Circle pillar;
      pillar.name = "pillar";
      pillar.radius_m = between(0.05, 0.2);
      pillar.height_m = 1;
      pillar.center_m = {between(-4, 4), between(-4, 4)};
      const Eigen::Vector2d dock = scene.objects[0].middle_m.head<2>();
      if (pillar.center_m.norm() < 0.6 || (pillar.center_m - dock).norm() < 0.6) continue;
      scene.circles.push_back(pillar);
    }
    world::MoverSpec person;
    person.name = "person_0";
    person.points_m = {{between(-4, 4), 4.5}, {between(-4, 4), 4.6}};
    scene.movers.push_back(person);
    SeeingRobot robot(scene);
    const double distance_m = between(0.6, 1.2);
    robot.Start("visual_servoing", {{"target", "dock"},
                                    {"distance", std::to_string(distance_m)},
                                    {"bearing", std::to_string(between(-0.4, 0.4))},
                                    {"speed", std::to_string(between(0.1, 0.5))}});
    const std::string end = robot.End(75, [&](double) {
      if (random() % 12 != 0) return;
      robot.fault = random() % 2 == 0 ? Fault::kNone : static_cast<Fault>(random() % 6);
      if (random() % 6 == 0) robot.SendOdometryFault(random() % 2 == 0 ? "freeze" : "jump 1 1");
      if (random() % 6 == 0) robot.SendOdometryFault("right");
    });
    const world::World world = robot.world();
    const std::string what = "seed " + std::to_string(seed) + ": " + end;
    EXPECT_EQ(world.fleet().robots()[0].collisions, 0) << what;
    EXPECT_LT(SpeedOf(world), 0.01) << what;
    EXPECT_LT(robot.longest_blind_s, kLongestBlindS) << what;
    if (robot.completed()) {
      EXPECT_NEAR(DistanceTo(world, 0), distance_m, 0.1) << what;
    }
    ++(robot.completed() ? reached : failed);
  }
  EXPECT_GT(reached, 0);
  EXPECT_GT(failed, 0);
}

TEST(ASeeingRobot, TouchesNothingAndDoesNotMoveBlindlyInRandomYards) {
  ExpectNoContact(1, 13);
}

TEST(ASeeingRobotNightly, TouchesNothingAndDoesNotMoveBlindlyInRandomYards) {
  ExpectNoContact(100, 300);
}

}  // namespace musher::seeing_robot_test
