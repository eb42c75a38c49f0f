// Two robots that have to pass each other in a corridor of the width of one: planner, controller
// and skills of both, on a simulated network, with bodies that see each other. Both arrive, and
// they touch neither each other nor a wall.

#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <random>
#include <string>

#include "musher/behavior/skill/manager.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"
#include "musher/test/modules/navigation/servers_on_network.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::two_robots_test {

using navigation::testing::ServersOnNetwork;
using navigation::testing::SimulatedRobot;
using skill::Status;
using ::testing::HasSubstr;

constexpr double kRadiusM = 0.2;

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

// The process musher-skills of one robot.
class Skills {
 public:
  Skills(transport::Node& node, const std::string& name, int priority, bool takes_part)
      : robot_(ConfigOf(name, priority, takes_part)), endpoints_(node, "") {
    robot_.Open(endpoints_, "");
    skill::Registry registry;
    EXPECT_TRUE(RegisterNavigationSkills(registry, robot_));
    manager_ = std::make_unique<skill::Manager>(registry.All());
    ticks_ = node.loop().Every(Milliseconds(100), [this, &node] {
      robot_.BeginStep(node.loop().Now());
      manager_->RunOnce(node.loop().Now());
      gave_way_ = gave_way_ || (started() && run().Path() == "GIVING_WAY");
    });
  }
  void GoTo(double x_m, double y_m) {
    const auto started =
        manager_->Start("navigate_to", {{"goal_pos", skill::Numbers{x_m, y_m, 0}}});
    EXPECT_TRUE(started) << started.error().message;
  }
  bool started() const { return manager_->Find("navigate_to") != nullptr; }
  const skill::Run& run() const { return *manager_->Find("navigate_to"); }
  bool ended() const { return started() && run().ended(); }
  bool gave_way() const { return gave_way_; }

 private:
  static skills::SkillsConfig ConfigOf(const std::string& name, int priority, bool takes_part) {
    const auto reading = skills::ReadSkillsText(
        "robot = \"" + name +
            "\"\nkind = \"jetbot\"\nradius_m = 0.2\npriority = " + std::to_string(priority) +
            "\n[topics]\nobjects = \"\"\n" + (takes_part ? "" : "robot_paths = \"\"\n"),
        "/tmp/robot.toml");
    return *reading.config;
  }

  skills::RosRobot robot_;
  transport::Endpoints endpoints_;
  std::unique_ptr<skill::Manager> manager_;
  bool gave_way_ = false;
  transport::LoopHandlePtr ticks_;
};

struct Scene {
  double bay_m = 7;
  navigation::Pose a{{1, 1.4, 0}, 0};
  navigation::Pose b{{13, 1.4, 0}, M_PI};
  int priority_a = 0, priority_b = 0;
  bool takes_part = true;
};

class TwoRobots {
 public:
  explicit TwoRobots(const Scene& scene)
      : walls_(navigation::testing::CorridorWithABay(scene.bay_m)),
        body_a_(*peers_, walls_, {.name = "a", .start = scene.a}),
        body_b_(*peers_, walls_, {.name = "b", .start = scene.b}) {
    eyes_ = peers_->loop().Every(Milliseconds(10), [this] {
      body_a_.discs = {{body_b_.pose().at, kRadiusM}};
      body_b_.discs = {{body_a_.pose().at, kRadiusM}};
      const double apart_m = navigation::Distance(body_a_.pose().at, body_b_.pose().at);
      least_gap_m_ = std::min(least_gap_m_, apart_m - 2 * kRadiusM);
    });
    StartServers();
    map_ =
        Must(transport::MakePublisher<msg::OccupancyGrid>(*peers_, "map", transport::kLatchedQos));
    EXPECT_TRUE(map_->Publish(navigation::testing::GridOf(walls_.map())));
    a_ = std::make_unique<Skills>(*node_a_, "a", scene.priority_a, scene.takes_part);
    b_ = std::make_unique<Skills>(*node_b_, "b", scene.priority_b, scene.takes_part);
    Run(1.5);
  }

  Skills& a() { return *a_; }
  Skills& b() { return *b_; }
  void Run(double seconds) { network_.RunFor(FromSeconds(seconds)); }
  bool RunToTheEnd(double seconds) {
    return network_.RunUntil([this] { return a_->ended() && b_->ended(); },
                             network_.now() + FromSeconds(seconds));
  }
  double least_gap_m() const {
    return std::min({least_gap_m_, body_a_.least_room_m(), body_b_.least_room_m()});
  }

 private:
  void StartServers() {
    navigation::PlannerConfig planner;
    navigation::ControllerConfig controller;
    for (const char* name : {"a", "b"}) {
      planner.robots.push_back(navigation::testing::PlannerTable(name));
      controller.robots.push_back(navigation::testing::ControllerTable(name));
    }
    servers_.Start(planner, controller);
  }

  transport::sim::Network network_{1};
  ServersOnNetwork servers_{network_};
  std::unique_ptr<transport::Node> node_a_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> node_b_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peers_ = network_.MakeNode("robot");
  const navigation::Clearance walls_;
  SimulatedRobot body_a_, body_b_;
  double least_gap_m_ = 10;
  transport::LoopHandlePtr eyes_;
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> map_;
  std::unique_ptr<Skills> a_, b_;
};

void ExpectBothArrive(TwoRobots& robots, const std::string& what) {
  EXPECT_TRUE(robots.RunToTheEnd(150)) << what;
  for (Skills* skills : {&robots.a(), &robots.b()}) {
    EXPECT_EQ(skills->run().feedback().status, Status::kCompleted)
        << what << ": " << skills->run().feedback().message;
  }
  EXPECT_GT(robots.least_gap_m(), 0) << what;
}

TEST(TwoRobotsInACorridor, BothArriveInEitherOrderOfTheirPriorities) {
  for (const int priority_b : {-1, 0, 1}) {
    Scene scene;
    scene.priority_b = priority_b;
    TwoRobots robots(scene);
    robots.a().GoTo(13, 1.4);
    robots.b().GoTo(1, 1.4);
    ExpectBothArrive(robots, "priority " + std::to_string(priority_b));
    EXPECT_EQ(robots.a().gave_way(), priority_b > 0);
    EXPECT_EQ(robots.b().gave_way(), priority_b <= 0);
  }
}

TEST(TwoRobotsInACorridor, StandWithoutContactAndFailIfTheyDoNotTakePart) {
  Scene scene;
  scene.takes_part = false;
  TwoRobots robots(scene);
  robots.a().GoTo(13, 1.4);
  robots.b().GoTo(1, 1.4);
  EXPECT_TRUE(robots.RunToTheEnd(200));
  EXPECT_GT(robots.least_gap_m(), 0);
  EXPECT_THAT(robots.a().run().feedback().message, HasSubstr("Blocked for"));
}

void ExpectRandomMeetings(std::uint64_t from, std::uint64_t to) {
  for (std::uint64_t seed = from; seed < to; ++seed) {
    std::mt19937_64 random(seed);
    const auto between = [&](double least, double most) {
      return std::uniform_real_distribution<double>(least, most)(random);
    };
    Scene scene;
    scene.bay_m = between(3.5, 10.5);
    scene.a = {{between(0.6, 4), 1.4, 0}, between(-M_PI, M_PI)};
    scene.b = {{between(10, 13.4), 1.4, 0}, between(-M_PI, M_PI)};
    scene.priority_a = static_cast<int>(random() % 2);
    scene.priority_b = static_cast<int>(random() % 2);
    TwoRobots robots(scene);
    const bool a_begins = random() % 2 == 0;
    if (a_begins) robots.a().GoTo(13, 1.4);
    if (!a_begins) robots.b().GoTo(1, 1.4);
    robots.Run(between(0, 5));
    if (a_begins) robots.b().GoTo(1, 1.4);
    if (!a_begins) robots.a().GoTo(13, 1.4);
    ExpectBothArrive(robots, "seed " + std::to_string(seed));
  }
}

TEST(TwoRobotsInACorridor, BothArriveFromRandomPlaces) {
  ExpectRandomMeetings(1, 2);
}

TEST(TwoRobotsNightly, BothArriveFromRandomPlaces) {
  ExpectRandomMeetings(100, 200);
}

}  // namespace musher::two_robots_test
